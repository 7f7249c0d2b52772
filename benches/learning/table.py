#!/usr/bin/env python3
"""Runs everything that docs/learning.md and docs/method.md print, into the folder OUT: tuning, then all arms on all worlds.

Usage: benches/learning/table.py OUT [PART…]      parts: tune, random-goals, corners, hard, boards, held-out, method, sensitivity, examples, times

Goes on where it was if OUT exists. Every arm runs twice, as it comes and with the settings that tuning chose
(NAME-tuned), but for the corners.
Needs Python 3.9 and cargo, nothing else. benches/learning/page.py puts the results into the documents.
"""

import itertools
import json
import math
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import protocol  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "target/release/eigentrail"
ROUNDS = 4
FLOOR = 1e-4  # regret ÷ sparse below which less is not better


def compare(world, arms, first_seed, out, sets=(), threads=0):
    """compare.json of one world; arms and seeds that `out` holds already are not run again."""
    command = [PROGRAM, "compare", f"scenarios/{world.scenario}.toml", "--seeds", f"{first_seed}..{first_seed + world.seeds}"]
    command += ["--arms", ",".join(arms), "--resume", "--no-report", "--json", "-q", "--out", out]
    command += ["--threads", threads] if threads else []
    for setting in (*world.sets, *sets):
        command += ["--set", setting]
    done = subprocess.run([str(part) for part in command], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"{world.name}: eigentrail ended with {done.returncode}")
    return json.loads(done.stdout)


def settings(name, base, values):
    """`--set` of an arm that begins as `base`."""
    return [f"arms.{name}.base={base}"] + [f"arms.{name}.{key}={value}" for key, value in values.items()]


def pairs(arm, windows):
    ranges = [[axis.values[i] for i in window] for axis, window in zip(arm.axes, windows)]
    return [dict(zip((axis.key for axis in arm.axes), values)) for values in itertools.product(*ranges)]


def grown(arm, windows, best):
    """The windows with the next value on each edge on which `best` lies."""
    result = []
    for axis, window in zip(arm.axes, windows):
        window = list(window)
        at = axis.values.index(best[axis.key])
        if at == window[0] and at > 0:
            window.insert(0, at - 1)
        if at == window[-1] and at + 1 < len(axis.values):
            window.append(at + 1)
        result.append(tuple(window))
    return result


def score(results, name):
    """Mean log of regret ÷ that of the sparse arm as it comes, over the worlds."""
    logs = []
    for result in results:
        arms = {arm["name"]: arm["regret"]["iqm"] for arm in result["arms"]}
        logs.append(math.log(max(arms[name] / max(arms["sparse"], 1e-9), FLOOR)))
    return sum(logs) / len(logs)


def tune(out):
    """Chooses the settings of every arm; into OUT/tuned.json."""
    windows = {arm.name: [axis.first for axis in arm.axes] for arm in protocol.ARMS}
    tried = {arm.name: {} for arm in protocol.ARMS}
    open_arms = list(protocol.ARMS)
    for _ in range(ROUNDS):
        names, sets, owners = [], [], {}
        for arm in open_arms:
            for values in pairs(arm, windows[arm.name]):
                key = json.dumps(values)
                if key not in tried[arm.name]:
                    name = f"{arm.name}-{len(tried[arm.name])}"
                    tried[arm.name][key] = None
                    names.append(name)
                    owners[name] = (arm, key)
                    sets += settings(name, arm.name, values)
        if not names:
            break
        results = [
            compare(world, ["sparse", *names], protocol.FIRST_TUNING_SEED, out / "tuning" / world.scenario, sets)
            for world in protocol.TUNING_WORLDS
        ]
        for name, (arm, key) in owners.items():
            tried[arm.name][key] = score(results, name)
        still = []
        for arm in open_arms:
            best = json.loads(min(tried[arm.name], key=tried[arm.name].get))
            wider = grown(arm, windows[arm.name], best)
            if wider != windows[arm.name]:
                windows[arm.name] = wider
                still.append(arm)
        open_arms = still
    chosen = {}
    for arm in protocol.ARMS:
        best = min(tried[arm.name], key=tried[arm.name].get)
        values = json.loads(best)
        edges = [
            axis.key
            for axis, window in zip(arm.axes, windows[arm.name])
            if axis.values.index(values[axis.key]) in (window[0], window[-1])
        ]
        ratio = math.exp(tried[arm.name][best])
        chosen[arm.name] = {"settings": values, "tried": len(tried[arm.name]), "ratio": ratio, "on_edge": edges}
    (out / "tuned.json").write_text(json.dumps(chosen, indent=1) + "\n")


def part(out, name):
    """All arms on the worlds of a part, as they come and, on most parts, tuned."""
    chosen = {} if name in protocol.AS_THEY_COME else json.loads((out / "tuned.json").read_text())
    for world in protocol.PARTS[name]:
        arms = protocol.arms_on(world)
        sets, tuned = [], []
        for arm in arms:
            if arm in chosen and not (name in protocol.SLOW_PARTS and arm in protocol.SLOW):
                tuned.append(f"{arm}-tuned")
                sets += settings(f"{arm}-tuned", arm, chosen[arm]["settings"])
        begun = time.time()
        compare(world, arms + tuned, protocol.FIRST_SEED, out / name / world.name.replace(" ", "_"), sets)
        print(f"{name}: {world.name}, {time.time() - begun:.0f} s", flush=True)


def method(out):
    """The arms of docs/method.md."""
    for world in protocol.METHOD_WORLDS:
        sets = []
        for name, values in protocol.METHOD_ARMS.items():
            sets += settings(name, "gcn-shaping-only" if name in protocol.RECIPES else "gcn", values)
        compare(world, ["sparse", *protocol.METHOD_ARMS], protocol.FIRST_SEED, out / "method" / world.name.replace(" ", "_"), sets)


def sensitivity(out):
    """The same worlds with other numbers of episodes and other limits."""
    for world in protocol.SENSITIVITY:
        compare(world, protocol.SENSITIVITY_ARMS, protocol.FIRST_SEED, out / "sensitivity" / world.name.replace(" ", "_"))


def examples(out):
    """The two examples that docs/method.md cites."""
    for name, arguments in (("transfer", ["20"]), ("rooms", [])):
        command = ["cargo", "run", "--release", "--locked", "--quiet", "--example", name, "--", *arguments]
        done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
        (out / f"{name}.txt").write_text(done.stdout)


def times(out):
    """How long a step takes; nothing else should run meanwhile."""
    for world in protocol.TIMES:
        left_out = protocol.EPISODE_PLANNERS if world.scenario in protocol.CELLS | protocol.THOUSANDS else set()
        arms = [name for name in protocol.TIMES_ARMS if name not in left_out]
        compare(world, arms, protocol.FIRST_SEED, out / "times" / world.name, threads=1)


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    out = Path(sys.argv[1]).resolve()
    steps = {"tune": tune} | {name: lambda out, name=name: part(out, name) for name in protocol.PARTS}
    steps |= {"method": method, "sensitivity": sensitivity, "examples": examples, "times": times}
    asked = sys.argv[2:] or list(steps)
    unknown = [name for name in asked if name not in steps]
    if unknown:
        sys.exit(f"{unknown[0]}: no such part; there are {', '.join(steps)}")
    out.mkdir(parents=True, exist_ok=True)
    subprocess.run(["cargo", "build", "--release", "--locked", "--quiet"], cwd=ROOT, check=True)
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, stdout=subprocess.PIPE, text=True).stdout.strip()
    (out / "commit").write_text(commit + "\n")
    for name in asked:
        begun = time.time()
        steps[name](out)
        print(f"{name}: {time.time() - begun:.0f} s", flush=True)


if __name__ == "__main__":
    main()
