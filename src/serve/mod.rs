//! A run as a page in the browser, while it goes on.
//!
//! ```text
//! run ──update──▶ desk ──drawing──▶ board ──▶ one thread per browser, which writes the newest drawing it has not sent
//! ```
//!
//! - The run's observer, [`LiveView`], leaves an update on the desk, and only when it is asked for one: somebody is looking, the one before has
//!   been drawn, and leaving them does not take more than a hundredth of the time. It never waits.
//! - One thread turns updates into the object that the page is drawn from.
//! - A browser that is slow misses drawings. It has a few seconds for its whole request and for each whole drawing,
//!   however it spreads them, and is dropped after that. Nothing is queued.
//! - `GET /` is the page, `GET /events` the drawings as
//!   [server-sent events](https://html.spec.whatwg.org/multipage/server-sent-events.html), and there is nothing else.
//!   Requests must name one host, and a local one unless the server was told to listen elsewhere, so that no page of another site
//!   can read a run through a name that it has pointed at this machine.
//! - With the run the server ends: browsers are sent the last drawing and the event `end`, and no thread stays.
//!
//! **Cost.** Over ten alternating pairs of runs (`rooms_50x50`, 130 000 episodes, with and without a reader that gets a
//! drawing a second) the steps per second of processor time of the run's thread differed by −14 to +1.5 %, median −2 %:
//! less than can be told from noise. `benches/live/cost.sh` measures it by the clock, with Chromium, on a machine that has
//! nothing else to do; where all processors are busy, the painter and the browser take their part of them as any program.
//!
//! Memory is bounded however long the run: of its rows some ten thousand are kept, later episodes several in a row; one
//! drawing lies on the board, and each of at most sixteen browsers may still be taking an older one.

mod board;
mod browser;
mod hasty;
mod http;
mod live_view;
mod painter;

pub use live_view::LiveView;

use crate::scenario::Scenario;
use board::Board;
use browser::{Browsers, Patience};
use live_view::LiveUpdate;
use painter::Desk;
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

/// How long browsers are given to take the last drawing.
const FAREWELL: Duration = Duration::from_secs(2);

/// Head of the page: what it says about the run beside its numbers.
#[derive(Clone, Debug)]
pub struct Title {
    /// The run.
    pub name: String,
    /// Its scenario.
    pub scenario: Scenario,
    /// The command line.
    pub arguments: Vec<String>,
}

/// Server of the live page. Dropping it ends it.
pub struct Server {
    address: SocketAddr,
    desk: Arc<Desk>,
    board: Arc<Board>,
    browsers: Arc<Browsers>,
    painter: Option<JoinHandle<()>>,
}

impl Server {
    /// Listens at `address`; port 0 takes any that is free.
    ///
    /// # Errors
    /// If the address cannot be had, or a thread cannot be started.
    pub fn start(address: SocketAddr, title: Title) -> io::Result<Self> {
        Self::start_with(address, title, Patience::default())
    }

    fn start_with(address: SocketAddr, title: Title, patience: Patience) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        let address = listener.local_addr()?;
        let board = Arc::new(Board::default());
        let desk = Arc::new(Desk::default());
        let painter = {
            let (desk, board) = (Arc::clone(&desk), Arc::clone(&board));
            let thread = std::thread::Builder::new().name("painter".to_owned());
            thread.spawn(move || painter::paint(&desk, &board, title))?
        };
        let browsers = Browsers::listen(listener, Arc::clone(&board), patience)?;
        Ok(Self {
            address,
            desk,
            board,
            browsers,
            painter: Some(painter),
        })
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// How many browsers are connected.
    pub fn num_browsers(&self) -> usize {
        self.browsers.count()
    }

    /// Whether to show how things stand: somebody is looking, and the update before has been drawn.
    fn wants(&self) -> bool {
        self.board.is_looked_at() && self.desk.is_free()
    }

    /// Shows how things stand, as soon as the painter gets to it.
    fn show(&self, update: LiveUpdate) {
        self.desk.leave(update);
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.desk.close();
        if let Some(painter) = self.painter.take() {
            // A panic there has been told on stderr, and must not hide what came of the run.
            let _ = painter.join();
        }
        self.board.end();
        self.browsers.dismiss(FAREWELL);
    }
}

#[cfg(test)]
mod tests;
