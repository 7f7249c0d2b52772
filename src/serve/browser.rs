//! One thread for the door, and one for each browser that has come in.

use super::board::{Board, News};
use super::hasty::Hasty;
use super::http::{Request, answer, begin_events, read_request};
use crate::report::live_page;
use std::collections::HashMap;
use std::io::{self, Write};
use std::net::{Ipv4Addr, Ipv6Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// More are turned away.
const MOST: usize = 16;

/// How long a browser may take; it is dropped after that.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patience {
    /// For the whole of its request.
    pub request: Duration,
    /// For the whole of the page, or of one drawing.
    pub answer: Duration,
}

impl Default for Patience {
    fn default() -> Self {
        Self {
            request: Duration::from_secs(5),
            answer: Duration::from_secs(10),
        }
    }
}

/// How often something is sent over a connection that has nothing to say.
const HEARTBEAT: Duration = Duration::from_secs(10);

/// How often it is looked whether a browser is still there.
const GLANCE: Duration = Duration::from_millis(500);

/// How long the first page waits for something to show.
const FIRST: Duration = Duration::from_secs(5);

/// Before the first episode has ended.
const NOTHING_YET: &str = "<!doctype html><meta charset=\"utf-8\"><meta http-equiv=\"refresh\" content=\"1\">\
<title>eigentrail</title><p>Waiting for the first episode to end…</p>";

/// The connections, and the thread that lets them in.
pub(super) struct Browsers {
    board: Arc<Board>,
    address: SocketAddr,
    patience: Patience,
    closed: AtomicBool,
    connected: Mutex<HashMap<u64, TcpStream>>,
    gone: Condvar,
    door: Mutex<Option<JoinHandle<()>>>,
}

impl Browsers {
    /// Lets browsers in from now on.
    pub fn listen(
        listener: TcpListener,
        board: Arc<Board>,
        patience: Patience,
    ) -> io::Result<Arc<Self>> {
        let browsers = Arc::new(Self {
            board,
            address: listener.local_addr()?,
            patience,
            closed: AtomicBool::new(false),
            connected: Mutex::default(),
            gone: Condvar::new(),
            door: Mutex::new(None),
        });
        let inside = Arc::clone(&browsers);
        let door = Builder::new()
            .name("door".to_owned())
            .spawn(move || inside.keep_the_door(&listener))?;
        *locked(&browsers.door) = Some(door);
        Ok(browsers)
    }

    pub fn count(&self) -> usize {
        locked(&self.connected).len()
    }

    /// Closes the door, and waits until everybody is gone; who is still there after `farewell` is cut off.
    pub fn dismiss(&self, farewell: Duration) {
        self.closed.store(true, Ordering::Release);
        // The door is waiting for somebody to knock.
        let _ = TcpStream::connect_timeout(&self.knock(), Duration::from_secs(1));
        if let Some(door) = locked(&self.door).take() {
            let _ = door.join();
        }
        let someone = |there: &mut HashMap<_, _>| !there.is_empty();
        let all = locked(&self.connected);
        let waited = self.gone.wait_timeout_while(all, farewell, someone);
        let (rest, _) = waited.unwrap_or_else(PoisonError::into_inner);
        for stream in rest.values() {
            let _ = stream.shutdown(Shutdown::Both);
        }
        // Their threads end at the next read or write, which fails at once.
        drop(self.gone.wait_while(rest, |there| !there.is_empty()));
    }

    /// An address that reaches the listener from here.
    fn knock(&self) -> SocketAddr {
        let mut address = self.address;
        match address {
            SocketAddr::V4(v4) if v4.ip().is_unspecified() => {
                address.set_ip(Ipv4Addr::LOCALHOST.into());
            }
            SocketAddr::V6(v6) if v6.ip().is_unspecified() => {
                address.set_ip(Ipv6Addr::LOCALHOST.into());
            }
            _ => {}
        }
        address
    }

    fn keep_the_door(self: Arc<Self>, listener: &TcpListener) {
        for (number, stream) in (0..).zip(listener.incoming()) {
            if self.closed.load(Ordering::Acquire) {
                return;
            }
            let Ok(stream) = stream else {
                // Out of file descriptors, perhaps: do not spin.
                std::thread::sleep(GLANCE);
                continue;
            };
            if self.count() < MOST {
                self.let_in(number, stream);
            } else {
                let _ = turn_away(stream);
            }
        }
    }

    fn let_in(self: &Arc<Self>, number: u64, stream: TcpStream) {
        let Ok(copy) = stream.try_clone() else { return };
        locked(&self.connected).insert(number, copy);
        let seat = Seat {
            browsers: Arc::clone(self),
            number,
        };
        let thread = Builder::new().name(format!("browser {number}"));
        // Whatever goes wrong on the wire, or if there are no more threads: it is the browser that is gone.
        let _ = thread.spawn(move || seat.browsers.attend(stream));
    }

    fn attend(&self, stream: TcpStream) -> io::Result<()> {
        stream.set_nodelay(true)?;
        let mut request = Hasty::new(&stream, self.patience.request);
        match read_request(&mut request, self.address.ip().is_loopback())? {
            Request::Page => self.send_page(&stream),
            Request::Events => self.send_events(&stream),
            Request::Refused(status) => {
                answer(&mut self.hasty(&stream), status, "text/plain", status)
            }
        }
    }

    /// For one answer from now on.
    fn hasty<'a>(&self, stream: &'a TcpStream) -> Hasty<'a> {
        Hasty::new(stream, self.patience.answer)
    }

    fn send_page(&self, stream: &TcpStream) -> io::Result<()> {
        let _looking = self.board.look();
        let page = match self.board.news(0, FIRST) {
            News::Drawing(drawing) => live_page(&drawing.title, &drawing.json),
            News::Nothing | News::End => NOTHING_YET.to_owned(),
        };
        answer(&mut self.hasty(stream), "200 OK", "text/html", &page)
    }

    fn send_events(&self, stream: &TcpStream) -> io::Result<()> {
        let _looking = self.board.look();
        begin_events(&mut self.hasty(stream))?;
        let mut known = 0;
        let mut sent = Instant::now();
        loop {
            match self.board.news(known, GLANCE) {
                News::Drawing(drawing) => {
                    known = drawing.number;
                    write!(self.hasty(stream), "data: {}\n\n", drawing.json)?;
                    sent = Instant::now();
                }
                News::End => {
                    (self.hasty(stream)).write_all(b"event: end\ndata: \n\n")?;
                    return stream.shutdown(Shutdown::Write);
                }
                News::Nothing if has_left(stream) => return Ok(()),
                News::Nothing if sent.elapsed() > HEARTBEAT => {
                    self.hasty(stream).write_all(b":\n\n")?;
                    sent = Instant::now();
                }
                News::Nothing => {}
            }
        }
    }
}

/// A connection that is counted until this is dropped, whatever happens to its thread.
struct Seat {
    browsers: Arc<Browsers>,
    number: u64,
}

impl Drop for Seat {
    fn drop(&mut self) {
        locked(&self.browsers.connected).remove(&self.number);
        self.browsers.gone.notify_all();
    }
}

/// Whether the other side has closed the connection. It has nothing else to say.
fn has_left(stream: &TcpStream) -> bool {
    let quiet = stream.set_nonblocking(true);
    let heard = stream.peek(&mut [0]);
    let back = stream.set_nonblocking(false);
    let silent = heard.is_err_and(|error| error.kind() == io::ErrorKind::WouldBlock);
    quiet.is_err() || back.is_err() || !silent
}

fn turn_away(mut stream: TcpStream) -> io::Result<()> {
    stream.set_write_timeout(Some(Duration::from_secs(1)))?;
    let status = "503 Service Unavailable";
    answer(&mut stream, status, "text/plain", "too many browsers\n")
}

/// A thread that panicked has not left a map half changed.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
