//! The server: who listens, who draws, and how it ends.

use super::board::Board;
use super::browser::{Browsers, Patience};
use super::painter::{self, Desk, LiveUpdate, Title};
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

/// How long browsers are given to take the last drawing.
const FAREWELL: Duration = Duration::from_secs(2);

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

    pub(super) fn start_with(
        address: SocketAddr,
        title: Title,
        patience: Patience,
    ) -> io::Result<Self> {
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

    /// The run has ended: shows its last state, to whoever comes later too, until this is dropped.
    pub fn end_of_run(&mut self) {
        self.desk.close();
        if let Some(painter) = self.painter.take() {
            // A panic there has been told on stderr, and must not hide what came of the run.
            let _ = painter.join();
        }
        self.board.end();
    }

    /// How many browsers are connected.
    pub fn num_browsers(&self) -> usize {
        self.browsers.count()
    }

    /// Whether to show how things stand: somebody is looking, and the update before has been drawn.
    pub(super) fn wants(&self) -> bool {
        self.board.is_looked_at() && self.desk.is_free()
    }

    /// Shows how things stand, as soon as the painter gets to it.
    pub(super) fn show(&self, update: LiveUpdate) {
        self.desk.leave(update);
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.end_of_run();
        self.browsers.dismiss(FAREWELL);
    }
}
