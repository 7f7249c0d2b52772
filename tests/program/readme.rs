//! What the pages say, done: every command in a block of `sh` is run where its page has it, in order, in one folder with the files that the
//! page shows; the glossary is held against the program's own list.

use assert_cmd::Command;
use eigentrail::scenario::BUILT_IN_ARMS;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A fenced block of a page.
struct Block {
    language: String,
    text: String,
    /// The file that it is, if the line before it is `<!-- file NAME -->`.
    file: Option<String>,
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn page(name: &str) -> String {
    fs::read_to_string(root().join(name)).unwrap()
}

fn blocks(page: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let (mut file, mut inside) = (None, false);
    for line in page.lines() {
        if let Some(language) = line.strip_prefix("```") {
            inside = !inside;
            if inside {
                blocks.push(Block {
                    language: language.to_owned(),
                    text: String::new(),
                    file: file.take(),
                });
            }
        } else if inside {
            let text = &mut blocks.last_mut().unwrap().text;
            *text += line;
            text.push('\n');
        } else if let Some(name) = line.strip_prefix("<!-- file ") {
            file = Some(name.trim_end_matches(" -->").to_owned());
        }
    }
    assert!(!inside, "a block that does not end");
    blocks
}

/// A folder in which the scenarios and data of the repository are where a clone has them.
fn clone() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    copy(
        &root().join("examples/data"),
        &folder.path().join("examples/data"),
    );
    folder
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, to.join(path.file_name().unwrap())).unwrap();
    }
}

/// Runs a line of a page: `eigentrail ARGUMENTS`, perhaps into a file.
fn run(folder: &Path, line: &str) {
    let (line, into) = match line.split_once(" > ") {
        Some((line, into)) => (line, Some(into)),
        None => (line, None),
    };
    let arguments = line.split_whitespace().skip(1);
    let mut command = Command::new(env!("CARGO_BIN_EXE_eigentrail"));
    command.current_dir(folder).args(arguments).arg("-q");
    let ran = command.assert().success();
    if let Some(into) = into {
        fs::write(folder.join(into), &ran.get_output().stdout).unwrap();
    }
}

/// The commands and files of a page, in order; how many commands there were.
fn walk(page: &str, folder: &Path) -> usize {
    let mut commands = 0;
    for block in blocks(page) {
        if let Some(name) = &block.file {
            fs::write(folder.join(name), &block.text).unwrap();
        }
        let lines = block.text.lines().filter(|_| block.language == "sh");
        for line in lines.filter(|line| line.starts_with("eigentrail ")) {
            // What waits for Ctrl-C, and what only a long measurement repeats.
            if line.contains(" --serve") {
                continue;
            }
            run(folder, line);
            commands += 1;
        }
    }
    commands
}

#[test]
fn every_command_of_the_readme_runs() {
    let folder = clone();
    let commands = walk(&page("README.md"), folder.path());
    assert!(commands >= 15, "{commands} commands");
    walk(&page("docs/runs.md"), folder.path());
}

#[test]
fn the_error_that_the_readme_shows_is_the_one_that_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("my-world.toml"), "[agent]\ngama = 0.9\n").unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_eigentrail"));
    command
        .current_dir(folder.path())
        .args(["run", "my-world.toml"]);
    let told = command.assert().code(3).get_output().stderr.clone();
    let told = String::from_utf8(told).unwrap();
    let shown = blocks(&page("README.md")).into_iter();
    let mut shown = shown.filter(|block| block.text.starts_with("error: "));
    let shown = shown.next().unwrap().text;
    assert!(told.starts_with(&shown), "{told}\nis not\n{shown}");
}

#[test]
fn the_glossary_has_every_arm_in_the_words_of_the_program() {
    let page = page("README.md");
    let (_, rest) = page.split_once("<!-- arms -->").unwrap();
    let (glossary, _) = rest.split_once("<!-- end arms -->").unwrap();
    let rows: Vec<&str> = glossary
        .lines()
        .filter(|line| line.starts_with("| `"))
        .collect();
    let expected: Vec<String> = BUILT_IN_ARMS
        .iter()
        .map(|arm| format!("| `{}` | {} |", arm.name, arm.about))
        .collect();
    assert_eq!(rows, expected);
}
