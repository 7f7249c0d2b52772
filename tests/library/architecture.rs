//! What each part must never know: the table of ARCHITECTURE.md, held to the imports in the code.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Parts that any part may use.
const COMMON: [&str; 9] = [
    "disk",
    "exponential",
    "memory",
    "npy",
    "parameter",
    "printable",
    "seeds",
    "time_stamp",
    "vector_state",
];

/// What a part may import besides.
const ALLOWED: &[(&str, &[&str])] = &[
    ("env", &[]),
    ("graph", &["env"]),
    ("spectral", &[]),
    ("features", &["graph", "spectral"]),
    ("gcn", &["graph", "features"]),
    ("shaping", &["graph", "gcn", "env"]),
    ("exploration", &["graph", "shaping", "env"]),
    ("agent", &["graph", "env"]),
    (
        "engine",
        &[
            "agent",
            "env",
            "exploration",
            "features",
            "gcn",
            "graph",
            "shaping",
            "spectral",
        ],
    ),
    (
        "scenario",
        &[
            "agent",
            "engine",
            "env",
            "exploration",
            "features",
            "gcn",
            "shaping",
            "spectral",
        ],
    ),
    ("statistics", &[]),
    ("archive", &["scenario", "statistics"]),
    (
        "runner",
        &[
            "agent",
            "archive",
            "engine",
            "env",
            "features",
            "gcn",
            "graph",
            "scenario",
            "shaping",
            "spectral",
            "statistics",
        ],
    ),
    (
        "report",
        &[
            "archive",
            "env",
            "exploration",
            "scenario",
            "shaping",
            "statistics",
        ],
    ),
    ("export", &["archive", "env", "graph"]),
    (
        "serve",
        &["archive", "report", "runner", "scenario", "statistics"],
    ),
    (
        "tensorboard",
        &[
            "archive",
            "env",
            "report",
            "runner",
            "shaping",
            "spectral",
            "statistics",
        ],
    ),
    ("telemetry", &[]),
];

/// Crates that only the feature `cli` brings.
const OF_THE_PROGRAM: [&str; 9] = [
    "anyhow",
    "clap",
    "comfy_table",
    "httparse",
    "indicatif",
    "png",
    "terminal_size",
    "tracing_subscriber",
    "zip",
];

/// Parts that say nothing to logs.
const SILENT: [&str; 14] = [
    "agent",
    "env",
    "exploration",
    "export",
    "features",
    "gcn",
    "graph",
    "report",
    "scenario",
    "serve",
    "shaping",
    "spectral",
    "statistics",
    "tensorboard",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// Every file of Rust below `folder`.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
    found
}

/// Its code without comments and without the tests at its end; nothing of a file of tests.
fn code(file: &Path) -> String {
    let name = file.file_stem().unwrap().to_string_lossy().into_owned();
    if name == "tests" || name == "fixtures" || name == "searched" || name == "testing" {
        return String::new();
    }
    let text = fs::read_to_string(file).unwrap();
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap();
    let lines = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// The parts of this crate that `part` names, itself left out.
fn imports(part: &str) -> BTreeSet<String> {
    let mut named = BTreeSet::new();
    for file in files(&root().join("src").join(part)) {
        for path in code(&file).split("crate::").skip(1) {
            let word = path
                .split(|c: char| !(c.is_alphanumeric() || c == '_'))
                .next();
            named.extend(word.map(str::to_owned));
        }
    }
    named.remove(part);
    named
}

#[test]
fn parts_import_what_they_may_and_nothing_else() {
    for (part, allowed) in ALLOWED {
        for import in imports(part) {
            let may = COMMON.contains(&&*import) || allowed.contains(&&*import);
            assert!(may, "{part} imports {import}");
        }
    }
    assert!(
        imports("engine").contains("shaping"),
        "imports are found at all"
    );
}

/// Whoever imports stands below what it imports: so there are no circles of parts.
#[test]
fn the_table_has_no_circles() {
    for (i, (part, allowed)) in ALLOWED.iter().enumerate() {
        for import in *allowed {
            let above = ALLOWED[..i].iter().any(|(name, _)| name == import);
            assert!(above, "{import} does not stand above {part}");
        }
    }
}

#[test]
fn experiments_are_run_without_what_shows_them() {
    for part in ["scenario", "statistics", "archive", "runner"] {
        for file in files(&root().join("src").join(part)) {
            let code = code(&file);
            for name in OF_THE_PROGRAM {
                let path = format!("{name}::");
                assert!(!code.contains(&path), "{}: {path}", file.display());
            }
        }
    }
}

#[test]
fn what_is_shown_is_never_made_by_the_engine_on_the_way() {
    for part in ["report", "export", "serve"] {
        assert!(!imports(part).contains("engine"), "{part} imports engine");
    }
}

#[test]
fn numeric_code_says_nothing() {
    let folders = SILENT.map(|part| root().join("src").join(part));
    let solver = root().join("crates/spectra/src");
    for file in folders
        .iter()
        .chain([&solver])
        .flat_map(|folder| files(folder))
    {
        let code = code(&file);
        for word in ["tracing::", "println!", "eprintln!", "dbg!("] {
            assert!(!code.contains(word), "{}: {word}", file.display());
        }
    }
}

#[test]
fn the_eigensolver_knows_nothing_of_learning() {
    for file in files(&root().join("crates/spectra/src")) {
        let code = code(&file).to_lowercase();
        for word in ["eigentrail::", "reward", "episode", "agent"] {
            assert!(!code.contains(word), "{}: {word}", file.display());
        }
    }
}
