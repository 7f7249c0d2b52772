#!/usr/bin/env python3
"""Puts the results of table.sh into docs/learning.md and README.md, between their markers.

Usage: benches/learning/page.py OUT        (the folder that table.sh has filled)
"""

import json
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def comparisons(out):
    """Every compare.json below `out`, by name of its part and of its world."""
    found = {}
    for path in sorted(Path(out).rglob("compare.json")):
        result = json.loads(path.read_text())
        part = path.relative_to(out).parts[0]
        result["arms"] = {arm["name"]: arm for arm in result["arms"]}
        result["timing"] = {arm["name"]: arm for arm in result["timing"]}
        found[part, result["scenario"]] = result
    return found


def count(value):
    return "–" if value is None else f"{value:,.0f}".replace(",", " ")


def short(value):
    digits = 4 if value < 0.01 else 3 if value < 0.3 else 2
    return f"{value:.{digits}f}"


def interval(ratio):
    if ratio is None:
        return "–"
    return f"{short(ratio['median'])} [{short(ratio['low'])}, {short(ratio['high'])}]"


def world(key, result):
    part, name = key
    slip = {"slip": " (0.3)", "slip-0.1": " (0.1)"}.get(part, "")
    return name + slip


def against_planner(result, arm="gcn"):
    return f"{result['arms'][arm]['regret']['iqm'] / result['arms']['planner']['regret']['iqm']:.2f}"


def default_arm(results, keys):
    yield "| world | seeds | optimal | gcn ÷ sparse | ÷ tuned sparse | heat ÷ sparse | gcn ÷ planner (IQM) | first goal of gcn | steps to 1.1×: sparse → gcn | final ÷ optimal | false maxima |"
    yield "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|"
    for key in keys:
        result = results[key]
        arms = result["arms"]
        gcn, sparse = arms["gcn"], arms["sparse"]
        tuned = gcn.get("ratio_to_tuned_sparse")
        yield (
            f"| {world(key, result)} | {len(result['seeds'])} | {result['optimal_steps']:.1f} | {interval(gcn['ratio_to_sparse'])} "
            f"| {interval(tuned)} | {interval(arms['heat']['ratio_to_sparse'])} | {against_planner(result)} "
            f"| {count(gcn['first_goal_step']['median'])} "
            f"| {count(sparse['steps_to_1_1x']['median'])} → {count(gcn['steps_to_1_1x']['median'])} "
            f"| {gcn['final_ratio']:.2f} | {gcn['spurious_maxima']} |"
        )


ALL = "gcn heat hops oracle gcn-shaping-only q-learning dyna-q planner report".split()


def all_arms(results, keys):
    yield "| regret ÷ sparse | " + " | ".join(ALL) + " |"
    yield "|---|" + "---:|" * len(ALL)
    for key in keys:
        result = results[key]
        cells = [interval(result["arms"][arm]["ratio_to_sparse"]) for arm in ALL]
        yield f"| {world(key, result)} | " + " | ".join(cells) + " |"


def times(results, keys):
    arms = ["sparse", "gcn", "heat", "planner"]
    yield "| world | ms a run: " + ", ".join(arms) + " | µs a step: the same | gcn ÷ planner: run, step |"
    yield "|---|---:|---:|---:|"
    for key in keys:
        result = results[key]
        runs = [result["timing"][arm]["wall_seconds"] * 1e3 for arm in arms]
        steps = [1e6 / result["timing"][arm]["steps_per_second"] for arm in arms]
        yield (
            f"| {world(key, result)} | {', '.join(f'{ms:.0f}' for ms in runs)} | {', '.join(f'{us:.2f}' for us in steps)} "
            f"| {runs[1] / runs[3]:.2f}, {steps[1] / steps[3]:.2f} |"
        )


def front(results, keys):
    yield "| world | default (`gcn`) | `heat` | R-max planner | `gcn` without exploration |"
    yield "|---|---:|---:|---:|---:|"
    for key in keys:
        arms = results[key]["arms"]
        cells = [interval(arms[arm]["ratio_to_sparse"]) for arm in ["gcn", "heat", "planner", "gcn-shaping-only"]]
        yield f"| {key[1]} | " + " | ".join(cells) + " |"


def fill(page, tables):
    path = ROOT / page
    text = path.read_text()
    for name, lines in tables.items():
        block = re.compile(rf"(<!-- {name} -->\n).*?(\n<!-- end -->)", re.S)
        text, hits = block.subn(lambda m: m[1] + "\n" + "\n".join(lines) + "\n" + m[2], text)
        if hits != 1:
            sys.exit(f"{page}: {hits} places marked <!-- {name} -->, want one")
    path.write_text(text)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    results = comparisons(sys.argv[1])
    small = [("small", name) for name in "open-5x5 four-rooms linked-grids open-15x15 rooms-25x25".split()]
    large = [("large", "rooms-50x50"), ("large-open", "open-50x50")]
    huge = [("huge", "rooms-100x100"), ("huge-open", "open-100x100"), ("huge", "maze-101")]
    huge += [("200", "rooms-200x200"), ("200", "maze-201")]
    hard = [key for key in results if key[0] == "hard"]
    slip = [key for part in ("slip-0.1", "slip") for key in results if key[0] == part]
    everything = small + large + huge + hard + slip
    fill(
        "docs/learning.md",
        {
            "default arm": default_arm(results, everything),
            "all arms": all_arms(results, small + large + hard + [k for k in slip if k[0] == "slip"]),
            "times": times(results, everything),
        },
    )
    fill("README.md", {"learning": front(results, small + large)})


if __name__ == "__main__":
    main()
