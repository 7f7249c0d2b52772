//! A connection with one time limit for all that is read from it and written to it.
//!
//! The time limits of sockets begin anew with every byte, so that who sends one every few seconds stays for hours.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// A stream until a moment.
#[derive(Debug)]
pub(super) struct Hasty<'a> {
    stream: &'a TcpStream,
    until: Instant,
}

impl<'a> Hasty<'a> {
    /// From now on for so long.
    pub fn new(stream: &'a TcpStream, time: Duration) -> Self {
        Self {
            stream,
            until: Instant::now() + time,
        }
    }

    /// What is left; an error if nothing is.
    fn left(&self) -> io::Result<Duration> {
        let left = self.until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        Ok(left)
    }
}

impl Read for Hasty<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(Some(self.left()?))?;
        self.stream.read(buffer)
    }
}

impl Write for Hasty<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(Some(self.left()?))?;
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::TcpListener;

    #[test]
    fn bytes_that_come_do_not_buy_time() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut there = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let (here, _) = listener.accept().unwrap();
        there.write_all(b"some bytes").unwrap();
        let mut hasty = Hasty::new(&here, Duration::from_secs(60));
        assert!(hasty.read(&mut [0; 4]).is_ok());
        hasty.until = Instant::now();
        let late = |error: io::Error| error.kind() == io::ErrorKind::TimedOut;
        assert!(hasty.read(&mut [0; 4]).is_err_and(late));
        assert!(hasty.write(b"x").is_err_and(late));
    }
}
