#!/usr/bin/env python3
"""Puts what the boards gave into docs/boards.md, between its markers.

    benches/boards/page.py OUT      (the folder that the boards have filled; tables of boards that were not run stay as they are)
"""

import collections
import pathlib
import re
import statistics
import sys

from results import ROOT, read

PAGE = ROOT / "docs" / "boards.md"
BUDGET = 1_000_000


def number(value):
    """With thin spaces of thousands, and no more digits than tell something."""
    if value in (None, ""):
        return "–"
    value = float(value)
    if value == int(value):
        return f"{int(value):,}".replace(",", " ")
    return f"{value:.3f}".rstrip("0").rstrip(".") if abs(value) < 100 else number(round(value))


def numbers(values):
    """Median [least, largest] of those that there are."""
    known = sorted(float(value) for value in values if value not in (None, ""))
    if not known:
        return "–"
    middle = number(statistics.median(known))
    return middle if known[0] == known[-1] else f"{middle} [{number(known[0])}, {number(known[-1])}]"


def groups(rows, *columns):
    grouped = collections.defaultdict(list)
    for row in rows:
        grouped[tuple(row[column] for column in columns)].append(row)
    return grouped


def table(head, rows):
    yield "| " + " | ".join(head) + " |"
    yield "|---|" + "---:|" * (len(head) - 1)
    for row in rows:
        yield "| " + " | ".join(str(cell) for cell in row) + " |"


def topogym(rows):
    """By family, and all together."""

    def line(name, part):
        reachable = [row for row in part if row["reachable"] == "1"]
        reached = [row for row in part if row["first_goal"]]
        # Where it was not reached its steps count as the largest ones: the median stays what it is.
        steps = [float(row["first_goal"] or "inf") for row in reachable]
        middle = statistics.median(steps) if steps else None
        told = "–" if middle in (None, float("inf")) else number(middle)
        most = number(max(float(row["first_goal"]) for row in reached)) if reached else "–"
        return [name, len(part), len(reachable), len(reached), told, most]

    families = groups(rows, "slice", "family")
    head = ["family", "worlds", "can be reached", "reached", "steps to the first goal, median", "most"]
    lines = [line(f"{family} ({part})", group) for (part, family), group in sorted(families.items())]
    slices = [line(f"**{part}**", group) for (part,), group in sorted(groups(rows, "slice").items())]
    yield from table(head, [*lines, *slices, line("**all**", rows)])
    missed = [f"{row['unit']} {row['world_seed']}" for row in rows if not row["first_goal"] and row["reachable"] == "1"]
    yield ""
    yield f"Missed: {', '.join(missed) if missed else 'none'}."


def bsuite(rows):
    head = ["experiment", "settings", "score", "episodes until solved, median [least, largest]", "regret an episode, of all", "of the last tenth"]
    lines = []
    for (name,), group in groups(rows, "experiment").items():
        sizes = [int(row["setting"]) for row in group]
        solved, regret = None, [float(row["mean_regret"]) for row in group]
        if name.startswith("deep_sea"):
            solved = numbers(row["solved_at"] for row in group)
            good = [row["solved_at"] and int(row["solved_at"]) < 2 ** int(row["setting"]) + 100 for row in group]
        elif name == "umbrella_length":
            good = [value < 0.5 for value in regret]
        else:
            good = [min(1.0, max(0.0, 1 - 10 * statistics.mean(regret)))]
        score = number(round(statistics.mean(float(bool(g)) if not isinstance(g, float) else g for g in good), 3))
        settings = f"{len(sizes)} ({min(sizes)} to {max(sizes)})"
        lines.append([f"`{name}`", settings, score, solved or "–", numbers(regret), numbers(row["last_tenth"] for row in group)])
    yield from table(head, lines)


def minigrid(rows):
    head = ["world", "seeds", "steps", "first success", "success at the end", "worst seed", "steps of an episode ÷ shortest way", "greedy policy is a shortest way"]
    lines = []
    for (name,), group in groups(rows, "world").items():
        ends = [float(row["success"]) for row in group]
        known = [row for row in group if row["optimal"]]
        over = numbers(round(float(row["length"]) / float(row["optimal"]), 3) for row in known)
        best = f"{sum(row['greedy'] == row['optimal'] for row in known)} of {len(known)}" if known else "–"
        name = name.removeprefix("MiniGrid-").removesuffix("-v0")
        mean = number(round(statistics.mean(ends), 3))
        first = numbers(row["first_success"] for row in group)
        lines.append([name, len(group), number(group[0]["steps"]), first, mean, number(min(ends)), over, best])
    yield from table(head, lines)


def toy_text(rows):
    head = ["world", "seeds", "steps", "first goal", "optimum", "greedy policy earns", "seeds at the optimum", "last tenth of the episodes"]
    lines = []
    for (name,), group in groups(rows, "world").items():
        best = float(group[0]["optimum"])
        at_best = sum(float(row["greedy"]) >= best - 0.01 * max(1.0, abs(best)) for row in group)
        columns = [numbers(row[column] for row in group) for column in ("first_goal", "greedy", "last_tenth")]
        lines.append([name, len(group), number(group[0]["steps"]), columns[0], number(best), columns[1], at_best, columns[2]])
    yield from table(head, lines)


def main():
    out = pathlib.Path(sys.argv[1])
    page = PAGE.read_text()
    for make in (topogym, bsuite, minigrid, toy_text):
        file = out / f"{make.__name__}.csv"
        if not file.exists():
            continue
        rows = read(file)
        commits = ", ".join(sorted({row["commit"] for row in rows}))
        text = "\n".join([*make(rows), "", f"*Commit {commits}.*"])
        begin, end = f"<!-- {make.__name__} -->", f"<!-- end {make.__name__} -->"
        page, count = re.subn(f"{begin}.*?{end}", lambda _, t=text: f"{begin}\n\n{t}\n\n{end}", page, flags=re.DOTALL)
        assert count == 1, make.__name__
    PAGE.write_text(page)


if __name__ == "__main__":
    main()
