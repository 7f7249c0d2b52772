#!/usr/bin/env python3
"""Mutation score of chosen parts: all mutants of a seeded sample in one build, each behind a switch. See README.md."""

import argparse
import collections
import json
import os
import random
import resource
import shutil
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import tree_sitter
import tree_sitter_rust

ROOT = Path(__file__).resolve().parents[2]
PARTS = (
    "src/graph/**",
    "src/shaping/**",
    "src/spectral/**",
    "crates/spectra/src/tracker/**",
    "src/archive/checkpoint.rs",
    "src/archive/container.rs",
    "src/runner/checkpoints.rs",
)
SWITCH = "EIGENTRAIL_MUTANT"
MODULE = f"""
#[doc(hidden)]
pub mod mutants {{
    static ACTIVE: std::sync::LazyLock<u32> =
        std::sync::LazyLock::new(|| std::env::var("{SWITCH}").map_or(0, |n| n.parse().unwrap()));
    #[inline]
    pub fn on(number: u32) -> bool {{
        *ACTIVE == number
    }}
}}
"""
LIBRARIES = ("src/lib.rs", "crates/spectra/src/lib.rs")
MEMORY = 8 << 30
# Five times what the tests usually take of the processor, and not by the clock: others may use the machine. One that sleeps for ever is left, too.
SLOWER = 5
PATIENCE = 5
HOUR = 3600


class Mutant:
    """One change, as `cargo mutants --list --json` tells it."""

    def __init__(self, number, found):
        self.number, self.name, self.file = number, found["name"], found["file"]
        self.genre, self.replacement = found["genre"], found["replacement"]
        self.start, self.end = (
            (place["line"] - 1, place["column"] - 1)
            for place in (found["span"]["start"], found["span"]["end"])
        )

    @property
    def is_on(self):
        return f"crate::mutants::on({self.number})"


def listed():
    """All mutants of the parts."""
    command = ["cargo", "mutants", "--list", "--json", "--workspace"]
    for part in PARTS:
        command += ["-f", part]
    output = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    return json.loads(output)


class Weaver:
    """The text of one file with its mutants behind switches."""

    def __init__(self, text, mutants):
        self.bytes = text.encode()
        self.lines = [0]
        for line in self.bytes.splitlines(keepends=True):
            self.lines.append(self.lines[-1] + len(line))
        parser = tree_sitter.Parser(tree_sitter.Language(tree_sitter_rust.language()))
        self.root = parser.parse(self.bytes).root_node
        self.at = collections.defaultdict(list)
        for mutant in mutants:
            node = self.node_of(mutant)
            if node is not None:
                self.at[node.id].append(mutant)
        self.woven = {mutant.number for there in self.at.values() for mutant in there}

    def offset(self, place):
        """Of a line and a column in characters."""
        row, column = place
        line = self.bytes[self.lines[row] : self.lines[row + 1]].decode()
        return self.lines[row] + len(line[:column].encode())

    def node_of(self, mutant):
        """The expression, arm or body that a mutant changes; `None` where it has no form with a switch."""
        start, end = self.offset(mutant.start), self.offset(mutant.end)
        node = self.root.descendant_for_byte_range(start, end)
        match mutant.genre:
            case "BinaryOperator":
                kinds = ("binary_expression", "compound_assignment_expr")
                return node.parent if node.parent and node.parent.type in kinds else None
            case "UnaryOperator":
                return node.parent if node.parent and node.parent.type == "unary_expression" else None
            case "MatchArm":
                return node if node.type == "match_arm" else None
            case "MatchArmGuard":
                while node and node.type != "match_pattern":
                    node = node.parent
                guard = node and node.child_by_field_name("condition")
                return guard if guard and guard.type not in ("let_condition", "let_chain") else None
            case "FnValue":
                while node and node.type != "function_item":
                    node = node.parent
                return node and node.child_by_field_name("body")
        return None

    def text(self, node=None):
        node = node or self.root
        plain = self.between(node)
        for mutant in self.at.get(node.id, ()):
            plain = self.switched(node, mutant, plain)
        return plain

    def between(self, node):
        """The node with all that is woven into its children."""
        out, at = "", node.start_byte
        for child in node.children:
            out += self.bytes[at : child.start_byte].decode() + self.text(child)
            at = child.end_byte
        return out + self.bytes[at : node.end_byte].decode()

    def switched(self, node, mutant, plain):
        match mutant.genre:
            case "BinaryOperator":
                left, right = (self.text(node.child_by_field_name(side)) for side in ("left", "right"))
                changed = f"{left} {mutant.replacement} {right}"
                return f"(if {mutant.is_on} {{ {changed} }} else {{ {plain} }})"
            case "UnaryOperator":
                operand = self.text(node.children[-1])
                return f"(if {mutant.is_on} {{ {operand} }} else {{ {plain} }})"
            case "MatchArmGuard":
                return f"(if {mutant.is_on} {{ {mutant.replacement} }} else {{ {plain} }})"
            case "MatchArm":
                pattern = node.child_by_field_name("pattern")
                guard = pattern.child_by_field_name("condition")
                rest = self.bytes[pattern.end_byte : node.end_byte].decode()
                if guard is None:
                    return f"{self.text(pattern)} if !{mutant.is_on} {rest}"
                head = self.bytes[pattern.start_byte : guard.start_byte].decode()
                return f"{head} !{mutant.is_on} && ({self.text(guard)}) {rest}"
            case "FnValue":
                value = "" if mutant.replacement == "()" else mutant.replacement
                return f"{{ if {mutant.is_on} {{ return {value}; }} {plain} }}"


def weave(copy, mutants, ever_woven):
    """Writes all files anew in which mutants are or were. The numbers of the mutants that are in them."""
    by_file, woven = {file: [] for file in ever_woven}, set()
    for mutant in mutants:
        by_file.setdefault(mutant.file, [])
        by_file[mutant.file].append(mutant)
    ever_woven.update(by_file)
    for file, of_file in by_file.items():
        weaver = Weaver((ROOT / file).read_text(), of_file)
        place(copy / file, weaver.text().encode())
        woven |= weaver.woven
    for library in LIBRARIES:
        place(copy / library, (ROOT / library).read_bytes() + MODULE.encode())
    return woven


def place(path, content):
    """Writes a file that is not there or is another one: what has not changed is not built again."""
    if not path.exists() or path.read_bytes() != content:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def copied(copy):
    """Brings the copy up to date. The files in it in which mutants are woven, which are left as they are."""
    listing = subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True)
    files, woven = set(filter(None, listing.stdout.split("\n"))), set()
    for old in copy.rglob("*"):
        place_of_old = old.relative_to(copy)
        if old.is_file() and place_of_old.parts[0] != "target" and str(place_of_old) not in files:
            old.unlink()
    for file in sorted(files):
        if (copy / file).exists() and "mutants::on(".encode() in (copy / file).read_bytes():
            woven.add(file)
        elif file not in LIBRARIES or not (copy / file).exists():
            place(copy / file, (ROOT / file).read_bytes())
    return woven - {"tests/mutants/run.py"}


def build(copy, kinds):
    """Builds the tests. Their programs by name, or the mutants that did not compile."""
    command = ["cargo", "test", "--locked", "--no-run", "--message-format=json", *kinds]
    flags = "--cap-lints=allow"
    environment = {**os.environ, "RUSTFLAGS": flags, "CARGO_PROFILE_DEV_DEBUG": "false"}
    process = subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True)
    programs, wrong = {}, set()
    for line in process.stdout.splitlines():
        message = json.loads(line)
        if message.get("executable") and message.get("profile", {}).get("test"):
            programs[message["target"]["name"]] = message["executable"]
        said = message.get("message") or {}
        if message.get("reason") == "compiler-message" and said["level"] == "error":
            wrong |= blamed(copy, said)
    if process.returncode and not wrong:
        sys.exit(f"the tests do not build, and no mutant is to blame:\n{process.stderr[-4000:]}")
    return programs, wrong


def blamed(copy, said):
    """The mutant whose switch stands nearest to each place of a compiler's error."""
    found = set()
    for span in said["spans"]:
        file = copy / span["file_name"]
        if not span["is_primary"] or not file.is_file():
            continue
        text = file.read_bytes()
        switch = b"crate::mutants::on("
        head = text.rfind(switch, 0, span["byte_end"] + len(switch))
        head = head if head >= 0 else text.find(switch)
        if head >= 0:
            found.add(int(text[head + len(switch) :].split(b")")[0]))
    return found


def limited(seconds):
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    os.setpgid(0, 0)


def fails(program, copy, number, arguments, seconds, folder):
    """Whether one program of tests fails under a mutant; left at the first failure."""
    with started(program, copy, number, arguments, seconds, folder) as process:
        late = threading.Timer(PATIENCE * seconds, kill, (process,))
        late.start()
        failed = any(name_of_failed(line) for line in process.stdout)
        late.cancel()
        if failed:
            kill(process)
        return process.wait() != 0 or failed


def started(program, copy, number, arguments, seconds, folder):
    # What proptest finds under one mutant is nothing to try under the next.
    environment = {**os.environ, SWITCH: str(number), "TMPDIR": folder, "RUST_BACKTRACE": "0",
                   "PROPTEST_DISABLE_FAILURE_PERSISTENCE": "1"}
    return subprocess.Popen([program, *arguments, "--test-threads=1"], cwd=folder_of(copy, program), env=environment,
                            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, errors="replace",
                            preexec_fn=lambda: limited(seconds))


def kill(process):
    try:
        os.killpg(process.pid, 9)
    except ProcessLookupError:
        pass


def name_of_failed(line):
    """Of the test that a line says has failed."""
    return line.split()[1] if line.startswith("test ") and line.rstrip().endswith("FAILED") else None


def folder_of(copy, program):
    return copy / "crates/spectra" if "eigentrail_spectra" in program else copy


def near(mutant, programs):
    """Programs of tests that are soon done, with their filters, the nearest first."""
    if mutant.file.startswith("crates/spectra"):
        yield programs["eigentrail_spectra"], ()
    else:
        module = mutant.file.removeprefix("src/").removesuffix(".rs").removesuffix("/mod").replace("/", "::")
        yield programs["eigentrail"], (module + "::",)
        yield programs["eigentrail"], (module.split("::")[0] + "::",)
        yield programs["eigentrail"], ()
    yield programs["golden"], ()


def far(mutant, programs):
    """What is left for those that have survived so far."""
    yield programs["library"], ()


def judge(mutant, stages, copy, usual):
    """`killed` or `survived`. `usual`: by program, the time it takes of the processor without a mutant, and the tests that fail even so."""
    folder = f"/dev/shm/mutants/{mutant.number}"
    Path(folder).mkdir(parents=True)
    try:
        for program, filters in stages:
            seconds, hopeless = usual[program]
            skip = [word for name in hopeless for word in ("--skip", name)]
            if fails(program, copy, mutant.number, [*filters, *skip], int(SLOWER * seconds) + 20, folder):
                return "killed"
        return "survived"
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def sampled(copy, size, seed, kinds, ever_woven):
    """At least as many mutants as are asked for, all of which compile, and the programs they are in."""
    everything = listed()
    drawn = random.Random(seed).sample(everything, len(everything))
    queue = [Mutant(number, found) for number, found in enumerate(drawn, 1)]
    print(f"{len(queue)} mutants in all", flush=True)
    chosen, left_out = [], 0
    while True:
        if len(chosen) < size:
            more = size - len(chosen) + size // 8
            chosen, queue = chosen + queue[:more], queue[more:]
        woven = weave(copy, chosen, ever_woven)
        left_out += len(chosen) - len(woven)
        chosen = [mutant for mutant in chosen if mutant.number in woven]
        programs, wrong = build(copy, kinds)
        if not wrong:
            return chosen, programs, left_out
        kept = [mutant for mutant in chosen if mutant.number not in wrong]
        if len(kept) == len(chosen):
            sys.exit("the copy does not build, and no mutant in it is to blame")
        left_out += len(chosen) - len(kept)
        chosen = kept
        print(f"{len(wrong)} mutants do not compile, {len(chosen)} are left", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sample", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--copy", type=Path, default=Path("/tmp/eigentrail-mutants"))
    parser.add_argument("--out", type=Path, help="a JSON line for each mutant that was judged; goes on where it ends")
    arguments = parser.parse_args()
    copy = arguments.copy
    ever_woven = copied(copy)
    shutil.rmtree("/dev/shm/mutants", ignore_errors=True)
    kinds = ["--workspace", "--exclude", "eigentrail-python", "--lib", "--test", "golden", "--test", "library"]
    chosen, programs, left_out = sampled(copy, arguments.sample, arguments.seed, kinds, ever_woven)
    outcomes = {}
    if arguments.out and arguments.out.exists():
        outcomes = {row["name"]: row["outcome"] for row in map(json.loads, arguments.out.open())}
    left = [mutant for mutant in chosen if mutant.name not in outcomes]
    for stages in (near, far):
        usual = {}
        for program in dict.fromkeys(program for mutant in left for program, _ in stages(mutant, programs)):
            usual[program] = undisturbed(program, copy)
            print(f"{Path(program).name}: {usual[program][0]:.0f} s, without {usual[program][1]}", flush=True)

        def one(mutant):
            outcome = judge(mutant, stages(mutant, programs), copy, usual)
            if outcome == "killed" or stages is far:
                outcomes[mutant.name] = outcome
                if arguments.out:
                    with arguments.out.open("a") as out:
                        print(json.dumps({"name": mutant.name, "outcome": outcome}), file=out)
            else:
                print(f"survived so far: {mutant.name}", flush=True)

        with ThreadPoolExecutor(arguments.jobs) as pool:
            list(pool.map(one, left))
        left = [mutant for mutant in left if mutant.name not in outcomes]
    for mutant in chosen:
        if outcomes[mutant.name] == "survived":
            print(f"survived: {mutant.name}")
    killed = sum(outcomes[mutant.name] == "killed" for mutant in chosen)
    print(f"{killed} of {len(chosen)} killed ({killed / len(chosen):.1%}), {left_out} left out, seed {arguments.seed}")


def undisturbed(program, copy):
    """How long a program of tests takes of the processor without a mutant, and the tests that fail even so."""
    folder = Path("/dev/shm/mutants/0")
    folder.mkdir(parents=True, exist_ok=True)
    before = used()
    with started(program, copy, 0, (), HOUR, str(folder)) as process:
        hopeless = sorted(filter(None, map(name_of_failed, process.stdout)))
    return used() - before, hopeless


def used():
    """Seconds of the processor that programs which have ended took."""
    of_children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return of_children.ru_utime + of_children.ru_stime


if __name__ == "__main__":
    main()
