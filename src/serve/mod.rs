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
//! - When the run has ended browsers are sent its last drawing and the event `end`, also those that come later; when the server is dropped
//!   no thread stays.
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
mod server;

pub use live_view::LiveView;
pub use painter::Title;
pub use server::Server;

/// Reads bytes from outside as a request.
#[cfg(any(test, fuzzing))]
pub(crate) fn read_any_request(mut bytes: &[u8], local: bool) {
    let _ = http::read_request(&mut bytes, local);
}

#[cfg(test)]
mod tests;
