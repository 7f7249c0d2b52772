//! Ctrl-C, a terminal that closes, and what clusters send before they kill: one way for all three.
//!
//! A signal ends the program at once, without leaving temporary files, unless a command has said what else it does:
//! then the first one asks it to end, and the next one ends the program.

use anyhow::{Context, Result};
use eigentrail::archive::files;
use eigentrail::telemetry::say;
use std::process::exit;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// 128 and the number of SIGINT.
const CTRL_C: u8 = 130;

/// Signals so close together are one: a shell passes on the SIGHUP that its terminal sends to everyone, and a cluster
/// may send its own to the program and to the script around it.
const ONE_OCCASION: Duration = Duration::from_millis(250);

/// What the first signal does, if it does not end the program.
type Request = Box<dyn FnOnce() + Send>;

static REQUEST: Mutex<Option<Request>> = Mutex::new(None);

/// The exit code of the last signal; 0 before there was one.
static RECEIVED: AtomicU8 = AtomicU8::new(0);

/// Begins to listen.
pub fn listen() -> Result<()> {
    let mut asked: Option<Instant> = None;
    on_each(move |code| {
        if asked.is_some_and(|at| at.elapsed() < ONE_OCCASION) {
            return;
        }
        RECEIVED.store(code, Ordering::Relaxed);
        let request = REQUEST
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        let Some(request) = request else {
            files::remove_temporaries();
            exit(i32::from(code));
        };
        asked = Some(Instant::now());
        request();
    })
    .context("cannot listen for signals")
}

/// From now on the first signal asks the work to end by this.
pub fn on_first(request: impl FnOnce() + Send + 'static) {
    replace_request(move || {
        say("interrupted: ending with what is done (once more to end at once)");
        request();
    });
}

/// A flag that the first signal sets.
pub fn stop_flag() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    on_first(move || flag.store(true, Ordering::Relaxed));
    stop
}

/// Waits for a signal, when there is no more work that it could interrupt.
pub fn wait() {
    let (tell, told) = std::sync::mpsc::sync_channel(1);
    replace_request(move || {
        let _ = tell.send(());
    });
    let _ = told.recv();
}

fn replace_request(request: impl FnOnce() + Send + 'static) {
    let mut waiting = REQUEST.lock().unwrap_or_else(PoisonError::into_inner);
    *waiting = Some(Box::new(request));
}

/// The exit code of a program that was interrupted.
pub fn exit_code() -> u8 {
    match RECEIVED.load(Ordering::Relaxed) {
        0 => CTRL_C,
        code => code,
    }
}

/// Calls `act` with the exit code of each signal, on a thread of its own. Where the system refuses one, signals do what
/// they do to any program.
#[cfg(unix)]
fn on_each(mut act: impl FnMut(u8) + Send + 'static) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut heard = vec![SIGINT, SIGTERM];
    if !is_ignored(SIGHUP) {
        heard.push(SIGHUP);
    }
    let (tell, told) = std::sync::mpsc::sync_channel(1);
    let listen = move || match signal_hook::iterator::Signals::new(heard) {
        Ok(mut signals) => {
            drop(tell.send(Ok(())));
            for signal in signals.forever() {
                act(128 + u8::try_from(signal).unwrap_or(0));
            }
        }
        Err(error) => drop(tell.send(Err(error))),
    };
    let thread = std::thread::Builder::new().name("signals".to_owned());
    match thread.spawn(listen) {
        Ok(_) => told.recv().unwrap_or(Ok(())),
        Err(_) => Ok(()),
    }
}

/// Whether whoever started the program wants it to outlive this signal, as `nohup` does.
#[cfg(unix)]
#[allow(unsafe_code, reason = "the standard library does not tell of signals")]
fn is_ignored(signal: i32) -> bool {
    // SAFETY: all fields of a `sigaction` may be zero; without a new action the call only fills in the present one.
    unsafe {
        let mut present: libc::sigaction = std::mem::zeroed();
        libc::sigaction(signal, std::ptr::null(), &raw mut present) == 0
            && present.sa_sigaction == libc::SIG_IGN
    }
}

/// Where there are no such signals, there is Ctrl-C.
#[cfg(not(unix))]
fn on_each(mut act: impl FnMut(u8) + Send + 'static) -> std::io::Result<()> {
    ctrlc::set_handler(move || act(CTRL_C)).map_err(std::io::Error::other)
}
