use super::browser::Patience;
use super::painter::LiveUpdate;
use super::*;
use crate::archive::{EpisodeRow, SeedResult, SeedTiming, Snapshot};
use crate::scenario::Scenario;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};

/// After so long something hangs.
const HANGS: Duration = Duration::from_secs(600);

fn title() -> Title {
    let text = "[env]\nrows = 3\ncols = 3\n".to_owned();
    let loaded = Scenario::parse(Path::new("small.toml"), text, &[]).unwrap();
    Title {
        name: "small".to_owned(),
        scenario: loaded.scenario,
        arguments: vec!["eigentrail".to_owned(), "run".to_owned()],
    }
}

fn server() -> Server {
    server_with(Patience::default())
}

fn server_with(patience: Patience) -> Server {
    Server::start_with("127.0.0.1:0".parse().unwrap(), title(), patience).unwrap()
}

/// A server whose drawings are more than any socket buffers, because of a word in the command line.
fn heavy_server(answer: Duration) -> Server {
    let mut title = title();
    title.arguments.push("x".repeat(20_000_000));
    let patience = Patience {
        answer,
        ..Patience::default()
    };
    Server::start_with("127.0.0.1:0".parse().unwrap(), title, patience).unwrap()
}

/// A run that has gone on for so many steps.
pub(super) fn update(step: u64) -> LiveUpdate {
    let snapshot = Snapshot {
        step,
        nodes: 1,
        potential: vec![0.0],
        ..Snapshot::default()
    };
    LiveUpdate {
        result: SeedResult {
            seed: 0,
            finished: false,
            episodes: step as usize,
            steps: step,
            regret: 0.0,
            optimal_steps: 4.0,
            final_mean_steps: 4.0,
            optimal_return: None,
            final_return: None,
            goals_moved_after: None,
            first_goal_step: None,
            nodes: 1,
            edges: 0,
            spectrum_refreshes: 0,
            gcn_fits: 0,
        },
        timing: SeedTiming {
            seed: 0,
            wall_seconds: 1.0,
            steps_per_second: step as f64,
            ..Default::default()
        },
        episodes: (1..=step)
            .map(|episode| EpisodeRow {
                episodes: 1,
                episode: episode - 1,
                step: 4 * episode,
                length: 4,
                plain_return: -4.0,
                shaped_return: -4.0,
                status: "terminated".into(),
                regret: 0.0,
                nodes: 1,
                edges: 0,
            })
            .collect(),
        refreshes: Vec::new(),
        snapshots: vec![snapshot],
        actions: vec!["on".to_owned()],
        labels: vec!["0,0".to_owned()],
        policy: Vec::new(),
        graph: Vec::new(),
    }
}

fn ask(server: &Server, path: &str) -> TcpStream {
    let mut stream = TcpStream::connect(server.address()).unwrap();
    stream.set_read_timeout(Some(HANGS)).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    stream
}

/// Until `true`, or panics if that hangs.
fn wait_for(what: &str, mut holds: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !holds() {
        assert!(begun.elapsed() < HANGS, "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// The next line of events that begins with `start`.
fn line(events: &mut impl BufRead, start: &str) -> String {
    let begun = Instant::now();
    loop {
        assert!(begun.elapsed() < HANGS, "{start}");
        let mut line = String::new();
        assert!(events.read_line(&mut line).unwrap() > 0, "the stream ended");
        if line.starts_with(start) {
            return line;
        }
    }
}

#[test]
fn the_run_is_asked_only_while_somebody_looks() {
    let server = server();
    assert!(!server.wants());
    let events = ask(&server, "/events");
    wait_for("somebody looks", || server.wants());
    server.show(update(1));
    wait_for("the painter has rested", || server.wants());
    drop(events);
    wait_for("nobody looks", || !server.wants());
    wait_for("no thread stays", || server.num_browsers() == 0);
}

#[test]
fn drawings_come_as_events_until_the_end() {
    let server = server();
    let mut events = BufReader::new(ask(&server, "/events"));
    wait_for("somebody looks", || server.wants());
    for step in [1, 2] {
        server.show(update(step));
        let data: serde_json::Value =
            serde_json::from_str(&line(&mut events, "data: ")[6..]).unwrap();
        assert_eq!(data["title"], "small");
        let episodes = data["arms"][0]["episodes"].as_array().unwrap();
        assert_eq!(episodes.len(), step as usize, "the whole run is drawn");
    }
    server.show(update(3));
    let end = std::thread::spawn(move || {
        let last = line(&mut events, "data: ");
        line(&mut events, "event: end");
        let mut rest = String::new();
        events.read_to_string(&mut rest).unwrap();
        (last, rest)
    });
    drop(server);
    let (last, rest) = end.join().unwrap();
    assert!(last.contains("\"step\":3"), "the last state is shown");
    assert_eq!(rest.trim(), "data:");
}

#[test]
fn a_browser_that_does_not_read_holds_nobody_up() {
    let server = heavy_server(Duration::from_secs(3600));
    let stalled = ask(&server, "/events");
    let mut reading = BufReader::new(ask(&server, "/events"));
    wait_for("both look", || server.num_browsers() == 2);
    // The stalled browser's thread gets stuck in the first one.
    for step in 1..=3 {
        wait_for("the painter has rested", || server.wants());
        server.show(update(step));
        line(&mut reading, "data: ");
    }
    assert_eq!(
        server.num_browsers(),
        2,
        "the stalled one is still waited for"
    );
    drop((reading, server)); // ends, although one browser has not taken what it was sent
    drop(stalled);
}

/// Whether the other side has closed the connection, once it has nothing more to say.
fn is_closed(stream: &mut TcpStream) -> bool {
    stream.set_nonblocking(true).unwrap();
    let heard = stream.read(&mut [0; 1024]);
    stream.set_nonblocking(false).unwrap();
    match heard {
        Ok(length) => length == 0,
        Err(error) => error.kind() != std::io::ErrorKind::WouldBlock,
    }
}

#[test]
fn a_request_in_drops_does_not_hold_a_seat() {
    let server = server_with(Patience {
        request: Duration::from_millis(100),
        ..Patience::default()
    });
    let mut trickling = TcpStream::connect(server.address()).unwrap();
    trickling.write_all(b"GET / HTTP/1.1\r\nX: ").unwrap();
    wait_for("its connection is closed", || {
        // Each byte comes in time; a limit for each of them would never be reached.
        let written = trickling.write_all(b"x");
        written.is_err() || is_closed(&mut trickling)
    });
    wait_for("its seat is free", || server.num_browsers() == 0);
}

#[test]
fn a_browser_that_reads_in_drops_is_dropped() {
    let server = heavy_server(Duration::from_secs(1));
    let mut sipping = ask(&server, "/events");
    sipping.read_exact(&mut [0; 12]).unwrap(); // it has a seat
    server.show(update(1));
    wait_for("its seat is free", || {
        // A little at a time, so that some of what is sent always gets through.
        let _ = sipping.read(&mut [0; 100]);
        server.num_browsers() == 0
    });
}

#[test]
fn seats_are_free_again_and_there_are_only_so_many() {
    let server = server();
    let seated: Vec<_> = (0..16).map(|_| ask(&server, "/events")).collect();
    wait_for("all seats are taken", || server.num_browsers() == 16);
    let mut answer = String::new();
    let mut late = TcpStream::connect(server.address()).unwrap();
    late.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 503"), "{answer}");
    assert_eq!(server.num_browsers(), 16);
    drop(seated);
    wait_for("all seats are free", || server.num_browsers() == 0);
}

#[test]
fn the_page_is_drawn_from_what_there_is() {
    let server = server();
    let mut stream = ask(&server, "/");
    wait_for("somebody looks", || server.wants());
    server.show(update(7));
    let mut page = String::new();
    stream.read_to_string(&mut page).unwrap();
    assert!(page.starts_with("HTTP/1.1 200 OK\r\n"));
    assert!(page.contains("connect-src 'self'") && page.contains("new EventSource('events')"));
    assert!(page.contains("\"step\":7"));
    let mut other = String::new();
    ask(&server, "/secret").read_to_string(&mut other).unwrap();
    assert!(other.starts_with("HTTP/1.1 404"));
}

#[test]
fn the_server_ends_with_nobody_there_and_gives_its_port_back() {
    let server = server();
    let address = server.address();
    drop(server);
    drop(Server::start(address, title()).unwrap());
}
