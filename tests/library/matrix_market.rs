//! Matrix Market files: round trips, nalgebra-sparse as the other party, one test per rule.

use eigentrail::graph::matrix_market::{self, MatrixMarketFault as Fault, parse};
use eigentrail::graph::{Adjacency, MatrixMarketError};
use proptest::prelude::*;

fn graph(n: usize, edges: &[(u32, u32, f64)]) -> Adjacency {
    let mut graph = Adjacency::with_nodes(n);
    edges.iter().for_each(|&(u, v, weight)| {
        graph.add_edge(u, v, weight);
    });
    graph
}

fn text_of(graph: &Adjacency) -> String {
    let mut bytes = Vec::new();
    matrix_market::write(&mut bytes, graph).unwrap();
    String::from_utf8(bytes).unwrap()
}

/// A file with a header of `kind` and these lines after it.
fn file(kind: &str, lines: &[&str]) -> String {
    format!(
        "%%MatrixMarket matrix coordinate {kind}\n{}\n",
        lines.join("\n")
    )
}

fn error(kind: &str, lines: &[&str]) -> MatrixMarketError {
    parse(&file(kind, lines)).unwrap_err()
}

proptest! {
    #[test]
    fn what_is_written_is_read_to_the_bit(
        n in 1..9_usize,
        edges in proptest::collection::vec((0..8_u32, 0..8_u32, prop_oneof![Just(1.0), 1e-300..1e300_f64]), 0..20),
    ) {
        let edges: Vec<_> = edges.into_iter().filter(|&(u, v, _)| (u.max(v) as usize) < n).collect();
        let graph = graph(n, &edges);
        let read = parse(&text_of(&graph)).unwrap();
        read.assert_consistent();
        prop_assert_eq!(read.to_csr(), graph.to_csr());
    }

    #[test]
    fn nalgebra_reads_what_we_write_and_we_read_what_it_writes(
        edges in proptest::collection::vec((0..6_u32, 0..6_u32, 0.1..9.0_f64), 1..12),
    ) {
        let graph = graph(6, &edges);
        let coo = nalgebra_sparse::io::load_coo_from_matrix_market_str::<f64>(&text_of(&graph)).unwrap();
        let dense = nalgebra::DMatrix::from(&coo);
        for (row, column) in (0..6).flat_map(|row| (0..6).map(move |column| (row, column))) {
            prop_assert_eq!(graph.to_csr().as_csr().get(row, column).copied().unwrap_or(0.0), dense[(row, column)]);
        }
        let theirs = nalgebra_sparse::io::save_to_matrix_market_str(&coo);
        prop_assert_eq!(parse(&theirs).unwrap().to_csr(), graph.to_csr());
    }

    #[test]
    fn no_text_panics(lines in proptest::collection::vec("[-0-9 .e%\tinfNa]{0,24}", 0..6), kind in 0..4_usize) {
        let kind = ["pattern symmetric", "real general", "integer general", "real symmetric"][kind];
        let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
        let sized = [&["3 3 2"], &lines[..]].concat();
        for text in [file(kind, &lines), file(kind, &sized), lines.join("\n")] {
            if let Ok(graph) = parse(&text) {
                graph.assert_consistent();
            }
        }
    }
}

#[test]
fn a_file_spanning_many_blocks_keeps_its_order_and_its_line_numbers() {
    let n = 20_000;
    let edges: Vec<_> = (1..n as u32).map(|v| (v - 1, v, 1.0)).collect();
    let path = graph(n, &edges);
    let text = text_of(&path);
    assert_eq!(parse(&text).unwrap().to_csr(), path.to_csr());
    let broken = text.replace("\n15001 15000\n", "\n15001 x\n");
    assert_eq!(parse(&broken).unwrap_err().line, Some(2 + 15_000));
}

#[test]
fn headers_in_any_case_comments_and_blank_lines_are_legal() {
    let text = "%%matrixMARKET Matrix Coordinate PATTERN Symmetric\r\n% Émile\n\n 3 3 2 \r\n2 1\n% in between\n\n\t3  2\r\n\n";
    assert_eq!(
        parse(text).unwrap().to_csr(),
        graph(3, &[(0, 1, 1.0), (1, 2, 1.0)]).to_csr()
    );
}

#[test]
fn all_supported_kinds_describe_the_same_graph() {
    let expected = graph(3, &[(0, 1, 2.0), (2, 2, 3.0)]).to_csr();
    for (kind, lines) in [
        ("real symmetric", &["3 3 2", "2 1 2.0", "3 3 3e0"][..]),
        ("real symmetric", &["3 3 2", "1 2 2", "3 3 +3."]), // upper triangle
        ("integer symmetric", &["3 3 2", "2 1 2", "3 3 3"]),
        ("real general", &["3 3 3", "3 3 3", "2 1 2", "1 2 2"]),
        ("integer general", &["3 3 3", "1 2 2", "2 1 2", "3 3 3"]),
    ] {
        assert_eq!(
            parse(&file(kind, lines)).unwrap().to_csr(),
            expected,
            "{kind}"
        );
    }
}

#[test]
fn isolated_nodes_and_no_entries_are_legal() {
    let empty = parse(&file("pattern symmetric", &["4 4 0"])).unwrap();
    assert_eq!((empty.num_nodes(), empty.num_edges()), (4, 0));
    assert_eq!(parse(&text_of(&empty)).unwrap().to_csr(), empty.to_csr());
}

#[test]
fn weights_of_zero_are_no_edges() {
    let read = parse(&file(
        "real general",
        &["2 2 3", "1 1 0", "1 2 0.0", "2 2 1"],
    ))
    .unwrap();
    read.assert_consistent();
    assert_eq!(read.to_csr(), graph(2, &[(1, 1, 1.0)]).to_csr());
}

#[test]
fn headers_that_are_none_are_refused() {
    for text in [
        "",
        "1 1 0",
        "%%MatrixMarket matrix coordinate real",
        "%%MatrixMarket vector coordinate real general",
    ] {
        let error = parse(text).unwrap_err();
        assert!(
            matches!(error.fault, Fault::Header { .. }) && error.line == Some(1),
            "{text}: {error}"
        );
    }
    for (kind, found) in [
        ("complex general", "complex"),
        ("real hermitian", "hermitian"),
        ("real skew-symmetric", "skew-symmetric"),
    ] {
        let error = error(kind, &["1 1 0"]);
        assert!(
            matches!(&error.fault, Fault::Unsupported { found: word, .. } if word == found),
            "{error}"
        );
    }
    let dense = parse("%%MatrixMarket matrix array real general\n1 1\n1.0\n").unwrap_err();
    assert!(matches!(
        dense.fault,
        Fault::Unsupported {
            supported: "coordinate",
            ..
        }
    ));
}

#[test]
fn sizes_that_are_none_are_refused() {
    let fault = |line: &str| error("pattern symmetric", &[line]).fault;
    assert!(matches!(fault("3 3"), Fault::Size { .. }));
    assert!(matches!(fault("3 3 x"), Fault::Size { .. }));
    assert!(matches!(fault("-3 -3 0"), Fault::Size { .. }));
    assert!(matches!(fault(""), Fault::Size { .. }));
    assert!(matches!(
        fault("3 4 0"),
        Fault::NotSquare {
            rows: 3,
            columns: 4
        }
    ));
    assert!(matches!(fault("0 0 0"), Fault::NoNodes));
    assert!(matches!(
        fault("4294967295 4294967295 0"),
        Fault::TooLarge {
            nodes: 4_294_967_295
        }
    ));
    assert!(matches!(
        fault("18446744073709551615 18446744073709551615 1"),
        Fault::TooLarge { .. }
    ));
    assert!(matches!(
        fault("3 3 18446744073709551615"),
        Fault::TooManyEntries { .. }
    ));
}

#[test]
fn the_number_of_entries_is_checked() {
    let missing = error("pattern symmetric", &["% two", "3 3 2", "2 1"]);
    assert!(matches!(
        missing.fault,
        Fault::EntryCount {
            size_line: 3,
            promised: 2,
            found: 1
        }
    ));
    assert_eq!(missing.line, Some(3));
    let surplus = error("pattern symmetric", &["3 3 1", "2 1", "", "3 1"]);
    assert!(
        matches!(
            surplus.fault,
            Fault::EntryCount {
                promised: 1,
                found: 2,
                ..
            }
        ) && surplus.line == Some(5)
    );
}

#[test]
fn malformed_entries_are_named_with_their_line() {
    for (kind, line) in [
        ("pattern symmetric", "2"),
        ("pattern symmetric", "2 1 1.0"),
        ("pattern symmetric", "2 one"),
        ("pattern symmetric", "2.0 1"),
        ("real symmetric", "2 1"),
        ("real symmetric", "2 1 x"),
        ("real symmetric", "2 1 1 1"),
        ("integer symmetric", "2 1 1.5"),
        (
            "integer symmetric",
            "2 1 99999999999999999999999999999999999999999",
        ),
    ] {
        let good = if kind.starts_with("pattern") {
            "3 3"
        } else {
            "3 3 1"
        };
        let error = error(kind, &["3 3 2", "% next is good", good, line]);
        assert!(
            matches!(&error.fault, Fault::Entry { found, .. } if found == line),
            "{kind} {line}: {error}"
        );
        assert_eq!(error.line, Some(5), "{error}");
    }
}

#[test]
fn indices_outside_are_named() {
    for (line, outside) in [
        ("0 1", "(0, 1)"),
        ("1 4", "(1, 4)"),
        ("99999999999999999999999 1", "(99999999999999999999999, 1)"),
    ] {
        let error = error("pattern symmetric", &["3 3 1", line]);
        assert!(
            matches!(error.fault, Fault::IndexOutOfRange { nodes: 3, .. }) && error.line == Some(3),
            "{error}"
        );
        assert!(error.to_string().contains(outside), "{error}");
    }
}

#[test]
fn weights_that_are_none_are_named() {
    for weight in [
        "NaN", "nan", "inf", "-inf", "-1", "-1e-300", "1e999", "Infinity",
    ] {
        let error = error(
            "real symmetric",
            &["3 3 2", "1 1 1", &format!("3 2 {weight}")],
        );
        assert!(
            matches!(
                error.fault,
                Fault::Weight {
                    row: 3,
                    column: 2,
                    ..
                }
            ) && error.line == Some(4),
            "{error}"
        );
    }
    let negative = error("integer general", &["1 1 1", "1 1 -1"]);
    assert!(matches!(
        negative.fault,
        Fault::Weight {
            row: 1,
            column: 1,
            weight: -1.0
        }
    ));
    let overflow = error("real symmetric", &["2 2 2", "1 1 1.7e308", "2 1 1.7e308"]);
    assert!(
        matches!(overflow.fault, Fault::DegreeOverflow { row: 1 }),
        "{overflow}"
    );
}

#[test]
fn repetitions_are_named_with_both_lines() {
    let twice = error("pattern symmetric", &["4 4 4", "4 3", "2 1", "1 2", "3 4"]);
    assert!(
        matches!(
            twice.fault,
            Fault::Repeated {
                row: 1,
                column: 2,
                first_line: 4
            }
        ) && twice.line == Some(5),
        "{twice}"
    );
    let general = error("real general", &["2 2 2", "1 2 0", "1 2 1"]);
    assert!(
        matches!(
            general.fault,
            Fault::Repeated {
                row: 1,
                column: 2,
                first_line: 3
            }
        ) && general.line == Some(4)
    );
}

#[test]
fn asymmetry_names_the_first_offending_entry_and_both_values() {
    let absent = error("pattern general", &["3 3 2", "3 3", "2 3"]);
    assert_eq!(absent.line, Some(4));
    assert!(
        absent
            .to_string()
            .ends_with("entry (2, 3) is 1, entry (3, 2) is 0"),
        "{absent}"
    );
    let different = error(
        "real general",
        &["3 3 4", "3 2 5", "2 3 4", "2 1 7.5", "1 2 7.25"],
    );
    assert_eq!(different.line, Some(6));
    assert!(
        different
            .to_string()
            .ends_with("entry (1, 2) is 7.25, entry (2, 1) is 7.5"),
        "{different}"
    );
}

#[test]
fn files_are_named_in_errors_and_written_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("graph.mtx");
    let missing = matrix_market::load(&path).unwrap_err();
    assert!(
        matches!(&missing.fault, Fault::Read(error) if error.kind() == std::io::ErrorKind::NotFound)
    );
    assert!(missing.to_string().starts_with(&path.display().to_string()));

    let graph = graph(3, &[(0, 2, 0.1)]);
    matrix_market::save(&path, &graph).unwrap();
    assert_eq!(matrix_market::load(&path).unwrap().to_csr(), graph.to_csr());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);

    std::fs::write(
        &path,
        b"%%MatrixMarket matrix coordinate pattern symmetric\n% \xE9\n2 2 1\n2 3\n",
    )
    .unwrap();
    let error = matrix_market::load(&path).unwrap_err();
    assert_eq!(
        error.to_string(),
        format!("{}:4: entry (2, 3) is outside of 1 ‥ 2", path.display())
    );
}
