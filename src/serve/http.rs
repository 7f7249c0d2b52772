//! As much of HTTP/1.1 as one page needs: a request is read, an answer written, the connection closed.

use std::io::{self, Read, Write};
use std::net::{IpAddr, Ipv6Addr};

/// Longer requests are refused.
const LONGEST: usize = 8192;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Request {
    /// The page.
    Page,
    /// The drawings as they come.
    Events,
    /// Something else; the status line that says so.
    Refused(&'static str),
}

/// Reads a request. `local` ones must name a local host.
///
/// # Errors
/// If the connection ends or times out before the request does.
pub(super) fn read_request(stream: &mut impl Read, local: bool) -> io::Result<Request> {
    let mut bytes = Vec::new();
    let mut part = [0; 1024];
    loop {
        let length = stream.read(&mut part)?;
        if length == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        bytes.extend_from_slice(&part[..length]);
        if let Some(request) = parse(&bytes, local) {
            return Ok(request);
        }
        if bytes.len() > LONGEST {
            return Ok(Request::Refused("431 Request Header Fields Too Large"));
        }
    }
}

/// The request, if it is whole.
fn parse(bytes: &[u8], local: bool) -> Option<Request> {
    let mut headers = [httparse::EMPTY_HEADER; 64];
    let mut request = httparse::Request::new(&mut headers);
    match request.parse(bytes) {
        Ok(httparse::Status::Partial) => return None,
        Ok(httparse::Status::Complete(_)) => {}
        Err(_) => return Some(Request::Refused("400 Bad Request")),
    }
    let Some(host) = host(&request) else {
        return Some(Request::Refused("400 Bad Request"));
    };
    Some(match (request.method, request.path) {
        _ if local && !is_local(host) => Request::Refused("403 Forbidden"),
        (Some("GET"), Some("/")) => Request::Page,
        (Some("GET"), Some("/events")) => Request::Events,
        (Some("GET"), _) => Request::Refused("404 Not Found"),
        _ => Request::Refused("405 Method Not Allowed"),
    })
}

/// The name of the host that a request is for, without a port; empty if an old one (HTTP/1.0) does not say. None if it is
/// not said once and clearly: what stands between might read another one.
fn host<'a>(request: &httparse::Request<'_, 'a>) -> Option<&'a str> {
    let mut hosts = (request.headers.iter()).filter(|h| h.name.eq_ignore_ascii_case("host"));
    match (hosts.next(), hosts.next()) {
        (Some(only), None) => host_name(std::str::from_utf8(only.value).ok()?),
        (None, _) if request.version == Some(0) => Some(""),
        _ => None,
    }
}

/// `host`, `host:port`, `[v6]` or `[v6]:port`, without the port; none for anything else, such as `user@host`.
fn host_name(host: &str) -> Option<&str> {
    let (name, port) = match host.rsplit_once(':') {
        Some((name, port)) if !port.ends_with(']') => (name, port),
        _ => (host, ""),
    };
    let digits = port.bytes().all(|b| b.is_ascii_digit());
    if !digits || !port.is_empty() && port.parse::<u16>().is_err() {
        return None;
    }
    let plain = match name.strip_prefix('[') {
        Some(v6) => (v6.strip_suffix(']')?).parse::<Ipv6Addr>().is_ok(),
        None => !name.is_empty() && name.bytes().all(is_in_name),
    };
    plain.then_some(name)
}

fn is_in_name(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || b"-._".contains(&byte)
}

/// Whether the name of a host is this machine for certain.
fn is_local(name: &str) -> bool {
    let address = match name.strip_prefix('[') {
        Some(v6) => v6.trim_end_matches(']'),
        None => name,
    };
    let address = address.parse::<IpAddr>();
    name.eq_ignore_ascii_case("localhost") || address.is_ok_and(|ip| ip.is_loopback())
}

/// Writes a whole answer.
pub(super) fn answer(
    stream: &mut impl Write,
    status: &str,
    kind: &str,
    body: &str,
) -> io::Result<()> {
    let length = body.len();
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}; charset=utf-8\r\nContent-Length: {length}\r\n\
         Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n"
    )?;
    stream.write_all(body.as_bytes())?;
    stream.flush()
}

/// Begins an answer that goes on until the connection is closed.
pub(super) fn begin_events(stream: &mut impl Write) -> io::Result<()> {
    stream.write_all(
        b"HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\n\
          X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\nretry: 1000\n\n",
    )?;
    stream.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(text: &str) -> Request {
        read_request(&mut text.as_bytes(), true).unwrap()
    }

    #[test]
    fn two_things_can_be_asked_for() {
        let get = |path: &str| request(&format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n"));
        assert_eq!(get("/"), Request::Page);
        assert_eq!(get("/events"), Request::Events);
        assert_eq!(get("/../etc"), Request::Refused("404 Not Found"));
        let post = request("POST / HTTP/1.1\r\nHost: localhost\r\n\r\n");
        assert_eq!(post, Request::Refused("405 Method Not Allowed"));
        assert_eq!(request("\0\r\n\r\n"), Request::Refused("400 Bad Request"));
        let long = format!("GET / HTTP/1.1\r\nX: {}", "x".repeat(10_000));
        assert!(matches!(request(&long), Request::Refused(status) if status.starts_with("431")));
        assert!(read_request(&mut &b"GET / HT"[..], true).is_err());
    }

    #[test]
    fn only_this_machine_is_local() {
        let from = |host: &str| request(&format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n"));
        for host in [
            "localhost",
            "LOCALHOST:80",
            "localhost:",
            "127.0.0.1:8765",
            "[::1]:1",
            "[::1]",
        ] {
            assert_eq!(from(host), Request::Page, "{host}");
        }
        for host in [
            "example.org",
            "localhost.example.org:80",
            "192.0.2.1",
            "0.0.0.0:1",
            "[2001:db8::1]",
        ] {
            assert_eq!(from(host), Request::Refused("403 Forbidden"), "{host}");
        }
        for host in [
            "",
            ":80",
            "me@localhost",
            "localhost@example.org",
            "localhost:8o",
            "localhost:80:80",
            "localhost:65536",
            "localhost, example.org",
            "local host",
            "::1",
            "[::1",
            "[::1]]",
            "[[::1]]",
            "[localhost]",
            "http://localhost",
        ] {
            assert_eq!(from(host), Request::Refused("400 Bad Request"), "{host}");
        }
        let elsewhere = "GET / HTTP/1.1\r\nHost: example.org\r\n\r\n";
        assert_eq!(request(elsewhere), Request::Refused("403 Forbidden"));
        let open = read_request(&mut elsewhere.as_bytes(), false).unwrap();
        assert_eq!(open, Request::Page);
    }

    #[test]
    fn a_host_is_named_once() {
        for hosts in [
            "",
            "Host: localhost\r\nHost: localhost\r\n",
            "Host: localhost\r\nX: y\r\nhOST: example.org\r\n",
            "Host: example.org\r\nHost: localhost\r\n",
        ] {
            let text = format!("GET / HTTP/1.1\r\n{hosts}\r\n");
            for local in [true, false] {
                let read = read_request(&mut text.as_bytes(), local).unwrap();
                assert_eq!(read, Request::Refused("400 Bad Request"), "{hosts}");
            }
        }
        let old = "GET / HTTP/1.0\r\n\r\n";
        assert_eq!(request(old), Request::Refused("403 Forbidden"));
        let open = read_request(&mut old.as_bytes(), false).unwrap();
        assert_eq!(open, Request::Page);
    }
}
