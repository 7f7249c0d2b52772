//! Exports of a run, read back by readers that know nothing of their writers.

use crate::runs::{eigentrail, two_seeds};
use std::collections::HashMap;
use std::fs;
use std::path::Path;

/// Calls `export` in `folder`; exit code, stdout, stderr.
fn export(folder: &Path, arguments: &[&str]) -> (i32, String, String) {
    let output = eigentrail()
        .current_dir(folder)
        .arg("export")
        .args(arguments)
        .output()
        .unwrap();
    (
        output.status.code().unwrap(),
        String::from_utf8(output.stdout).unwrap(),
        String::from_utf8(output.stderr).unwrap(),
    )
}

/// Columns of a CSV file.
fn columns(path: &Path) -> HashMap<String, Vec<String>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let header = reader.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let column = |place: usize| rows.iter().map(|row| row[place].to_owned()).collect();
    (0..header.len())
        .map(|place| (header[place].to_owned(), column(place)))
        .collect()
}

#[test]
fn tables_hold_every_seed() {
    let folder = tempfile::tempdir().unwrap();
    two_seeds(folder.path());
    let (code, out, _) = export(folder.path(), &["run", "--to", "csv", "-o", "out"]);
    assert_eq!((code, out.lines().count()), (0, 4));
    let read = |name: &str| columns(&folder.path().join(name));
    for (table, file) in [
        ("episodes", "episodes"),
        ("refreshes", "refreshes"),
        ("transitions", "graph"),
    ] {
        let table = read(&format!("out/{table}.csv"));
        let seeds = ["0000", "0003"].map(|seed| read(&format!("run/seed-{seed}/{file}.csv")));
        for (name, first) in &seeds[0] {
            let both = [first.clone(), seeds[1][name].clone()].concat();
            let same = table[name].iter().zip(&both).all(|(a, b)| {
                // The same number may be written in two ways.
                a == b || a.parse::<f64>().unwrap() == b.parse::<f64>().unwrap()
            });
            assert!(same && table[name].len() == both.len(), "{file}: {name}");
        }
        let count = |seed: &str| table["seed"].iter().filter(|s| *s == seed).count();
        let len = |part: &HashMap<String, Vec<String>>| part.values().next().unwrap().len();
        assert_eq!((count("0"), count("3")), (len(&seeds[0]), len(&seeds[1])));
    }
    let states = read("out/states.csv");
    let phi: Vec<f64> = states["potential"]
        .iter()
        .map(|v| v.parse().unwrap())
        .collect();
    assert!(phi.iter().any(|&v| v < -1.0) && phi.iter().all(|&v| v <= 0.0));
    let visits = states["visits"].iter().map(|v| v.parse::<u64>().unwrap());
    let steps = read("out/transitions.csv");
    let steps = steps["count"].iter().map(|v| v.parse::<u64>().unwrap());
    assert_eq!(visits.sum::<u64>(), steps.sum::<u64>());
}

#[test]
fn arrays_are_a_stored_archive_of_npy_files() {
    let folder = tempfile::tempdir().unwrap();
    two_seeds(folder.path());
    let (code, ..) = export(folder.path(), &["run", "--to", "npz", "-o", "a.npz"]);
    assert_eq!(code, 0);
    let bytes = fs::read(folder.path().join("a.npz")).unwrap();
    let mut archive = zip::ZipArchive::new(std::io::Cursor::new(&bytes)).unwrap();
    let original = npyz::NpyFile::new(
        fs::read(folder.path().join("run/seed-0003/eigenvectors.npy"))
            .unwrap()
            .as_slice(),
    )
    .map(|file| (file.shape().to_vec(), file.into_vec::<f64>().unwrap()))
    .unwrap();
    let entry = archive.by_name("eigenvectors/seed-0003.npy").unwrap();
    assert_eq!(entry.compression(), zip::CompressionMethod::Stored);
    let copy = npyz::NpyFile::new(entry).unwrap();
    assert_eq!(copy.shape(), original.0);
    assert_eq!(copy.into_vec::<f64>().unwrap(), original.1);
    let status = npyz::NpyFile::new(archive.by_name("episodes/status.npy").unwrap()).unwrap();
    let status = status.into_vec::<String>().unwrap();
    assert_eq!(status.len(), 60);
    assert!(status.iter().any(|s| s == "terminated"));
    // Of equal runs, equal bytes.
    export(folder.path(), &["run", "--to", "npz", "-o", "b.npz"]);
    assert_eq!(bytes, fs::read(folder.path().join("b.npz")).unwrap());
}

#[test]
fn graphs_are_those_of_the_run() {
    let folder = tempfile::tempdir().unwrap();
    two_seeds(folder.path());
    let seed = "run/seed-0003";
    let rows = |name: &str| {
        let text = fs::read_to_string(folder.path().join(seed).join(name)).unwrap();
        text.lines().count() - 1
    };
    let (nodes, edges) = (rows("states.csv"), rows("graph.csv"));
    let (code, graphml, _) = export(folder.path(), &[seed, "--to", "graphml", "-o", "-"]);
    assert_eq!(code, 0);
    assert_eq!(graphml.matches("<node ").count(), nodes);
    assert_eq!(graphml.matches("<edge ").count(), edges);
    assert!(graphml.contains("<data key=\"phi\">-"));
    let (code, ..) = export(folder.path(), &[seed, "--to", "dot"]);
    let dot = fs::read_to_string(folder.path().join("graph.dot")).unwrap();
    assert_eq!((code, dot.matches("->").count()), (0, edges));
}

#[test]
fn nothing_is_overwritten_without_a_word() {
    let folder = tempfile::tempdir().unwrap();
    two_seeds(folder.path());
    fs::write(folder.path().join("mine"), "years of work").unwrap();
    let refused = |arguments: &[&str], word: &str| {
        let (code, out, err) = export(folder.path(), arguments);
        assert_eq!((code, out.as_str()), (3, ""), "{err}");
        assert!(err.contains(word), "{err}");
    };
    for format in ["csv", "npz"] {
        refused(&["run", "--to", format, "-o", "mine"], "--force");
        refused(&["nowhere", "--to", format], "not a run folder");
        refused(
            &["run", "--to", format, "-o", "-"],
            "only graphml, dot and mtx",
        );
    }
    for format in ["graphml", "dot", "mtx"] {
        refused(&["run", "--to", format, "-o", "x"], "run/seed-0000");
    }
    assert_eq!(
        fs::read_to_string(folder.path().join("mine")).unwrap(),
        "years of work"
    );
    let again = ["run", "--to", "npz", "-o", "mine", "--force"];
    assert_eq!(export(folder.path(), &again).0, 0);
    let gone = folder.path().join("run/seed-0003/graph.csv");
    fs::write(
        &gone,
        "from,action,to,count,reward_sum,terminal\n0,0,9999,1,0,false\n",
    )
    .unwrap();
    refused(&["run/seed-0003", "--to", "dot", "-o", "y"], "graph.csv: ");
}

#[cfg(not(feature = "parquet"))]
#[test]
fn without_parquet_the_message_says_how_to_get_it() {
    let folder = tempfile::tempdir().unwrap();
    two_seeds(folder.path());
    let (code, _, err) = export(folder.path(), &["run", "--to", "parquet"]);
    assert_eq!(code, 3);
    assert!(err.contains("--features parquet"), "{err}");
    assert!(!folder.path().join("export").exists());
}
