#!/usr/bin/env python3
"""How soon the search finds what there is: the tables of docs/method.md, "What the search is worth".

    benches/learning/search.py [--program target/release/eigentrail] [--seeds 200] [--turn-seeds 50] [--boards 30]

Prints Markdown. Steps to the first goal, goals at a random place of each seed's own (seeds from 20000): the default against the arm
`by-action`, seed by seed; medians, and the geometric mean of the ratios with its 95 % interval (normal, of the logarithms). Then the deep
sea as bsuite scores it and the rivers: share of the optimum over all episodes, and for the sea in how many episodes the treasure was
found with certainty a tenth of the time. About twelve minutes on two cores.
"""

import argparse
import csv
import json
import math
import statistics
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

FIRST_SEED = 20000
MAPS = ["rooms_50x50", "rooms_25x25", "open_15x15", "open_50x50", "u_trap", "maze_101"]
TURNS = ["rooms_50x50", "maze_101", "open_50x50"]


def call(program, *arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, arguments))}: {done.stderr}")
    return done.stdout


def first_goals(program, scenario, seeds, settings):
    """By arm: steps to the first goal, by seed."""
    with tempfile.TemporaryDirectory() as folder:
        settings = [part for setting in settings for part in ("--set", setting)]
        out = Path(folder) / "out"
        call(program, "compare", scenario, "--arms", "gcn,by-action", "--seeds", f"{FIRST_SEED}..{FIRST_SEED + seeds}",
             "--quiet", "--no-report", *settings, "--out", out)
        rows = list(csv.DictReader(next(out.rglob("compare.csv")).open()))
    steps = {}
    for row in (row for row in rows if row["arm"] != "sparse"):  # which compare always runs
        if not row["first_goal_step"]:
            raise SystemExit(f"{scenario}: no goal found with seed {row['seed']} by {row['arm']}")
        steps.setdefault(row["arm"], []).append(int(row["first_goal_step"]))
    return steps["gcn"], steps["by-action"]


def compare_row(name, ours, theirs):
    logs = [math.log(a / b) for a, b in zip(ours, theirs)]
    mean = statistics.mean(logs)
    half = 1.96 * statistics.stdev(logs) / math.sqrt(len(logs))
    low, middle, high = (f"{math.exp(mean + by):.2f}" for by in (-half, 0, half))
    medians = f"{statistics.median(ours):.0f} | {statistics.median(theirs):.0f}"
    print(f"| {name} | {len(logs)} | {medians} | {middle} [{low}, {high}] |", flush=True)
    return mean


def first_goal_table(program, worlds, corners, seeds, settings):
    print("\n| world | seeds | by place (median) | by action (median) | ratio [95 %] |\n|---|---|---|---|---|")
    means = []
    for world in worlds:
        scenario = f"scenarios/{world}_random_goals.toml"
        means.append(compare_row(world, *first_goals(program, scenario, seeds, settings)))
    for world in corners:  # where straight runs end: no measure of a search, so they are not in the mean
        compare_row(f"{world}, its own goal", *first_goals(program, f"scenarios/{world}.toml", seeds, settings))
    print(f"\nGeometric mean of the goals anywhere: {math.exp(statistics.mean(means)):.2f}")


def returns(program, scenario, seed, settings):
    with tempfile.TemporaryDirectory() as folder:
        settings = [part for setting in settings for part in ("--set", setting)]
        out = Path(folder) / "out"
        call(program, "run", scenario, "--seed", seed, "--quiet", "--no-report", *settings, "--out", out)
        rows = csv.DictReader(next(out.rglob("episodes.csv")).open())
        return [float(row["return"]) for row in rows]


def optimum(program, scenario, settings):
    settings = [part for setting in settings for part in ("--set", setting)]
    return json.loads(call(program, "check", scenario, "--json", *settings))["optimal_return"]


def board_row(program, name, scenario, seeds, settings):
    best = optimum(program, scenario, settings)
    with ThreadPoolExecutor(2) as pool:
        runs = list(pool.map(lambda seed: returns(program, scenario, FIRST_SEED + seed, settings), range(seeds)))
    shares = sorted(statistics.mean(run) / best for run in runs)
    last = sorted(statistics.mean(run[-len(run) // 10:]) / best for run in runs)
    solved = [next((n for n, total in enumerate(running_totals(run), 1) if n >= 20 and total > 0.1 * n * best), None) for run in runs]
    found = [n for n in solved if n is not None]
    latest = max(found) if found else "–"
    print(f"| {name} | {len(runs[0])} | {len(found)} of {seeds} | {latest} | {shares[0]:.2f} | {statistics.median(shares):.2f} | {last[0]:.2f} |", flush=True)


def running_totals(values):
    total = 0.0
    for value in values:
        total += value
        yield total


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="target/release/eigentrail")
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--turn-seeds", type=int, default=50)
    parser.add_argument("--boards", type=int, default=30)
    options = parser.parse_args()
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True).stdout.strip()
    print(f"At {commit}, seeds from {FIRST_SEED}. Steps to the first goal:")
    first_goal_table(options.program, MAPS, ["four_rooms"], options.seeds, ["run.episodes=8"])
    print("\nThe same with `env.actions = \"turns\"`:")
    first_goal_table(options.program, TURNS, [], options.turn_seeds, ["run.episodes=2", "env.actions=turns"])
    print("\n| board | episodes | a tenth of the optimum on average | by episode | share of the optimum: worst seed | median | last tenth, worst seed |")
    print("|---|---|---|---|---|---|---|")
    for kind in ["deep_sea_10", "deep_sea_stochastic_10"]:
        for size in [10, 20, 50]:
            settings = [f"env.size={size}", "run.episodes=10000"]
            board_row(options.program, f"{kind[:-3]}, {size} rows", f"scenarios/{kind}.toml", options.boards, settings)
    for scenario in ["river_swim_6", "river_swim_20"]:
        board_row(options.program, scenario, f"scenarios/{scenario}.toml", options.boards, ["run.episodes=3000"])


if __name__ == "__main__":
    main()
