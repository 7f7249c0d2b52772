use super::*;
use crate::report::{EpisodeRow, SeedResult, SeedTiming};
use crate::runner::Snapshot;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::Instant;

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
    Server::start("127.0.0.1:0".parse().unwrap(), title()).unwrap()
}

/// A run that has gone on for so many steps.
fn moment(step: u64) -> Moment {
    let snapshot = Snapshot {
        step,
        nodes: 1,
        potential: vec![0.0],
        ..Snapshot::default()
    };
    Moment {
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
        },
        episodes: vec![EpisodeRow {
            step: 4 * step,
            length: 4,
            plain_return: -4.0,
            shaped_return: -4.0,
            status: "terminated".to_owned(),
            regret: 0.0,
            nodes: 1,
            edges: 0,
        }],
        refreshes: Vec::new(),
        snapshots: vec![snapshot],
        labels: vec!["0,0".to_owned()],
        policy: Vec::new(),
        graph: Vec::new(),
    }
}

fn ask(server: &Server, path: &str) -> TcpStream {
    let mut stream = TcpStream::connect(server.address()).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(20)))
        .unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    stream
}

/// Until `true`, or panics after some seconds.
fn wait_for(what: &str, holds: impl Fn() -> bool) {
    let begun = Instant::now();
    while !holds() {
        assert!(begun.elapsed() < Duration::from_secs(20), "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// The next line of events that begins with `start`.
fn line(events: &mut impl BufRead, start: &str) -> String {
    let begun = Instant::now();
    loop {
        assert!(begun.elapsed() < Duration::from_secs(20), "{start}");
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
    server.show(moment(1));
    assert!(!server.wants(), "the painter has not rested yet");
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
        server.show(moment(step));
        let data: serde_json::Value =
            serde_json::from_str(&line(&mut events, "data: ")[6..]).unwrap();
        assert_eq!(data["title"], "small");
        let episodes = data["arms"][0]["episodes"].as_array().unwrap();
        assert_eq!(episodes.len(), step as usize, "rows are added up");
    }
    server.show(moment(3));
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
    let server = server();
    let stalled = ask(&server, "/events");
    let mut reading = BufReader::new(ask(&server, "/events"));
    wait_for("both look", || server.num_browsers() == 2);
    // More than any socket buffers: the stalled browser's thread must get stuck.
    let heavy = |step| {
        let mut moment = moment(step);
        moment.snapshots[0].potential = (0..400_000).map(|i| i as f32 / 7.0).collect();
        moment.snapshots[0].nodes = 400_000;
        moment
    };
    for step in 1..=3 {
        wait_for("the painter has rested", || server.wants());
        let begun = Instant::now();
        server.show(heavy(step));
        assert!(begun.elapsed() < Duration::from_millis(200));
        line(&mut reading, "data: ");
    }
    let begun = Instant::now();
    drop((reading, server));
    assert!(begun.elapsed() < FAREWELL + Duration::from_secs(5));
    drop(stalled);
}

#[test]
fn the_page_is_drawn_from_what_there_is() {
    let server = server();
    let mut stream = ask(&server, "/");
    wait_for("somebody looks", || server.wants());
    server.show(moment(7));
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
