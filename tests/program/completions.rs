//! Completion by a shell, as it asks for it.

use crate::program::Program;
use std::process::Command;

/// What bash offers for the last of `words`.
fn offered(program: &Program, words: &[&str]) -> Vec<String> {
    let ask = "source <(eigentrail completions bash)
        COMP_WORDS=(\"$@\")
        COMP_CWORD=$(($# - 1))
        _clap_complete_eigentrail eigentrail \"${!#}\"
        printf '%s\\n' \"${COMPREPLY[@]}\"";
    let binary = std::path::Path::new(env!("CARGO_BIN_EXE_eigentrail"));
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let paths = std::env::split_paths(&paths);
    let folder = binary.parent().unwrap().to_owned();
    let paths = std::env::join_paths(std::iter::once(folder).chain(paths)).unwrap();
    let output = Command::new("bash")
        .args(["-c", ask, "bash"])
        .args(words)
        .current_dir(program.folder())
        .env("PATH", paths)
        .output()
        .unwrap();
    let offered = String::from_utf8(output.stdout).unwrap();
    offered.lines().map(str::to_owned).collect()
}

#[test]
fn scenarios_are_offered_by_name_and_by_file() {
    let program = Program::new();
    program.file("rooms_of_mine.toml", "");
    program.file("rooms.csv", "");
    for command in ["run", "check", "show", "compare", "sweep", "figures"] {
        let offered = offered(&program, &["eigentrail", command, "rooms_"]);
        assert!(offered.contains(&"rooms_25x25".to_owned()), "{offered:?}");
        assert!(
            offered.contains(&"rooms_of_mine.toml".to_owned()),
            "{offered:?}"
        );
        assert!(
            offered.iter().all(|word| word.starts_with("rooms_")),
            "{offered:?}"
        );
    }
}

#[test]
fn arms_are_offered_one_after_the_other() {
    let program = Program::new();
    let first = offered(
        &program,
        &["eigentrail", "compare", "smoke", "--arms", "plan"],
    );
    assert!(first.contains(&"planner".to_owned()), "{first:?}");
    let next = offered(
        &program,
        &["eigentrail", "compare", "smoke", "--arms", "sparse,plan"],
    );
    assert!(next.contains(&"sparse,planner".to_owned()), "{next:?}");
}

#[test]
fn keys_are_offered_for_a_grid() {
    let program = Program::new();
    let sweep = ["eigentrail", "sweep", "smoke"];
    let arms = offered(&program, &[&sweep[..], &["--arms", "plan"]].concat());
    assert!(arms.contains(&"planner".to_owned()), "{arms:?}");
    let keys = offered(&program, &[&sweep[..], &["--grid", "agent.gam"]].concat());
    assert!(
        keys.iter().any(|key| key.starts_with("agent.gamma")),
        "{keys:?}"
    );
}

#[test]
fn every_shell_has_a_script_that_asks_the_program() {
    let program = Program::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = program.prints(&["completions", shell]);
        assert!(script.contains("EIGENTRAIL_COMPLETE"), "{shell}: {script}");
        let mut asked = program.call(&["--", "eigentrail", "run", "four_r"]);
        asked
            .env("EIGENTRAIL_COMPLETE", shell)
            .env("_CLAP_COMPLETE_INDEX", "2");
        let output = asked.assert().success().get_output().clone();
        let words = String::from_utf8(output.stdout).unwrap();
        assert!(words.contains("four_rooms_slip"), "{shell}: {words}");
    }
}
