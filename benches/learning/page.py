#!/usr/bin/env python3
"""Puts the results of table.py into docs/learning.md, docs/method.md and README.md, between their markers.

Usage: benches/learning/page.py OUT        (the folder that table.py has filled; tables of parts that it has not run stay as they are)
"""

import json
import re
import statistics
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import protocol  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
PUBLISHED = ["psrl", "mbie-eb", "ucbvi", "dyna-q-plus"]


def read(out, part, world):
    folder = out / part / world.name.replace(" ", "_")
    path = folder / "compare.json"
    if not path.exists():
        return None
    result = json.loads(path.read_text())
    result["folder"] = folder
    result["by_name"] = {arm["name"]: arm for arm in result["arms"]}
    result["clock"] = {arm["name"]: arm for arm in result["timing"]}
    return result


def parts(out, names=protocol.PARTS):
    """(world, result) of every world that was run, in the order of the protocol."""
    pairs = [(world, read(out, name, world)) for name in names for world in protocol.PARTS[name]]
    return [(world, result) for world, result in pairs if result]


def complete(out, name, worlds):
    """Whether a part has been run to its end."""
    return all(read(out, name, world) for world in worlds)


def number(value):
    if value is None:
        return "–"
    if value == 0:
        return "0"
    if abs(value) >= 1000:
        return f"{value:,.0f}".replace(",", " ")
    digits = 4 if abs(value) < 0.01 else 3 if abs(value) < 0.3 else 2 if abs(value) < 30 else 0
    return f"{value:.{digits}f}"


def interval(part):
    if part is None or part["median"] is None:
        return "–"
    return f"{number(part['median'])} [{number(part['low'])}, {number(part['high'])}]"


def share(value):
    return "–" if value is None else f"{100 * value:.0f} %"


def of_optimum(result, name):
    """Median over the seeds of what the final greedy policy earns as a share of the optimum: 1 + (R − R*) ÷ |R*|; none where R* = 0."""
    shares = []
    for path in sorted((result["folder"] / "arms" / name).glob("seed-*.json")):
        run = json.loads(path.read_text())["result"]
        best, earned = run["optimal_return"], run["greedy_return"]
        if best and earned is not None:
            shares.append(1 + (earned - best) / abs(best))
    return statistics.median(shares) if shares else None


def cell(result, name):
    """Regret ÷ sparse, share of the optimum, how many policies fail."""
    arm = result["by_name"].get(name)
    if arm is None:
        return ""
    return f"{number(arm['ratio_to_sparse']['median'])} · {number(of_optimum(result, name))} ({share(arm['failures'])})"


def over(result, arm, other):
    """Regret of an arm ÷ that of another, interquartile means."""
    arms = result["by_name"]
    if arm not in arms or other not in arms or arms[other]["regret"]["iqm"] <= 0:
        return None
    return arms[arm]["regret"]["iqm"] / arms[other]["regret"]["iqm"]


def best(result, names):
    """The name with the least regret, of those that were run."""
    known = [name for name in names if name in result["by_name"]]
    return min(known, key=lambda name: result["by_name"][name]["regret"]["iqm"], default=None)


def default_arm(results):
    yield "| world | seeds | R* (mean) | `gcn` ÷ sparse | ÷ tuned sparse | ÷ `planner-frontier` | ÷ best published learner | first goal (step) | greedy policy earns | share of the optimum | fails | fails without advice | worst seed | epochs |"
    yield "|---|" + "---:|" * 13
    for world, result in results:
        gcn = result["by_name"]["gcn"]
        rival = best(result, [*PUBLISHED, *(f"{name}-tuned" for name in PUBLISHED)])
        against = f"{number(over(result, 'gcn', rival))} ({rival})" if rival else "–"
        cells = [
            world.name,
            len(result["seeds"]),
            number(result["optimal_return"]),
            interval(gcn["ratio_to_sparse"]),
            number(over(result, "gcn", "sparse-tuned")),
            number(over(result, "gcn", "planner-frontier")),
            against,
            number(gcn["first_goal_step"]["median"]),
            interval(gcn["greedy_return"]),
            number(of_optimum(result, "gcn")),
            share(gcn["failures"]),
            share(gcn["failures_unadvised"]),
            gcn["worst_seed"],
            number(gcn["gcn_epochs"]),
        ]
        yield "| " + " | ".join(str(cell) for cell in cells) + " |"


def all_arms(results, names):
    """A row for each arm, a column for each world."""
    yield "| regret ÷ sparse · share of the optimum (fails) | " + " | ".join(world.name for world, _ in results) + " |"
    yield "|---|" + "---:|" * len(results)
    for name in names:
        cells = [cell(result, name) for _, result in results]
        if any(cells):
            yield f"| {name} | " + " | ".join(cells) + " |"


def profile(results, names):
    """Dolan & Moré 2002: share of worlds on which an arm has at most τ times the regret of the best arm there."""
    limits = (1.1, 1.5, 2, 5, 10, 100)
    yield "| arm | worlds | " + " | ".join(f"τ = {limit}" for limit in limits) + " |"
    yield "|---|---:|" + "---:|" * len(limits)
    rows = []
    for name in names:
        ratios = []
        for _, result in results:
            arms = {arm: found["regret"]["iqm"] for arm, found in result["by_name"].items() if arm in names}
            least = min(arms.values())
            if name in arms:
                ratios.append(arms[name] / least if least > 0 else float(arms[name] > 0) * 1e9 + 1)
        if ratios:
            rows.append((name, len(ratios), [sum(r <= limit for r in ratios) / len(ratios) for limit in limits]))
    for name, count, shares in sorted(rows, key=lambda row: -sum(row[2])):
        yield f"| {name} | {count} | " + " | ".join(f"{value:.2f}" for value in shares) + " |"


def verdicts(results, names):
    yield "| arm against `gcn`, paired | worlds with less regret | equivalent (± 10 %) | more | nothing shown |"
    yield "|---|---:|---:|---:|---:|"
    for name in names:
        found = [row["verdict"] for _, result in results for row in result["differences"] if row["arm"] == name]
        if found:
            yield f"| {name} | " + " | ".join(str(found.count(v)) for v in ("less", "equivalent", "more", "open")) + " |"


def tuning(out):
    yield "| arm | chosen | configurations | regret ÷ sparse on the tuning worlds (geometric mean) | on an edge of what may be tried |"
    yield "|---|---|---:|---:|---|"
    for name, found in json.loads((out / "tuned.json").read_text()).items():
        chosen = ", ".join(f"{key.split('.')[1]} {value}" for key, value in found["settings"].items())
        edges = ", ".join(key.split(".")[1] for key in found["on_edge"]) or "–"
        yield f"| {name} | {chosen} | {found['tried']} | {number(found['ratio'])} | {edges} |"


def times(out):
    names = protocol.TIMES_ARMS
    yield "| µs a step | " + " | ".join(names) + " |"
    yield "|---|" + "---:|" * len(names)
    for world in protocol.TIMES:
        clock = read(out, "times", world)["clock"]
        cells = [number(1e6 / clock[name]["steps_per_second"]) if name in clock else "" for name in names]
        yield f"| {world.name} | " + " | ".join(cells) + " |"


def sensitivity(out):
    results = [(world, read(out, "sensitivity", world)) for world in protocol.SENSITIVITY]
    return all_arms([(w, r) for w, r in results if r], protocol.SENSITIVITY_ARMS[1:])


def method_results(out):
    results = [(world, read(out, "method", world)) for world in protocol.METHOD_WORLDS]
    return [(world, result) for world, result in results if result]


def factorial(out):
    results = method_results(out)
    yield "| search | shaped reward | look-ahead advice | training | " + " | ".join(world.name for world, _ in results) + " |"
    yield "|---|---|---|---|" + "---:|" * len(results)
    for name in protocol.FACTORIAL:
        factors = ["yes" if word == "1" else "no" for word in re.findall(r"-([01])", name)]
        if factors[1:3] == ["no", "no"]:
            factors[3] = "–"
        cells = [interval(result["by_name"][name]["ratio_to_sparse"]) for _, result in results]
        yield "| " + " | ".join(factors + cells) + " |"


def recipes(out):
    results = method_results(out)
    yield "| arm | settings over the default | " + " | ".join(world.name for world, _ in results) + " |"
    yield "|---|---|" + "---:|" * len(results)
    for name, values in protocol.RECIPES.items():
        laid = " ".join(f"`{key}={value}`" for key, value in values.items())
        cells = [interval(result["by_name"][name]["ratio_to_sparse"]) for _, result in results]
        yield f"| {name} | {laid} | " + " | ".join(cells) + " |"


def transfer(out):
    """The output of the example, a row for each question instead of one for each arm."""
    yield "| question | heat | coldest heat | gcn, fitted here, pvf / random / constant | gcn, carried, pvf / random / constant | hops |"
    yield "|---|---|---|---|---|---|"
    errors, worlds = {}, []
    for line in (out / "transfer.txt").read_text().splitlines():
        if title := re.fullmatch(r"(\w+), \d+ seeds", line):
            worlds.append(title[1].lower())
        elif cells := re.match(r"\| ([a-z-]+) \| ([a-z:-]+) \| ([\d.]+) \|", line):
            errors[worlds[-1], cells[1], cells[2]] = cells[3]
    networks = [[f"{kind}:{features}" for features in ("pvf", "random", "constant")] for kind in ("here", "carried")]
    columns = [["heat"], ["coldest"], *networks, ["hops"]]
    for world in worlds:
        for question in ("new-goal", "new-map", "new-nodes", "missing-edges", "false-edges"):
            found = [[errors[world, question, arm] for arm in arms if (world, question, arm) in errors] for arms in columns]
            yield f"| {world}, `{question}` | " + " | ".join(" / ".join(cell) or "–" for cell in found) + " |"


def rooms(out):
    """The output of the example as one table."""
    yield "| world (eigenvectors, clustering) | φ | error | false maxima | ms: from nothing | another goal | one room changed |"
    yield "|---|---|---|---|---|---|---|"
    world = ""
    for line in (out / "rooms.txt").read_text().splitlines():
        if title := re.match(r"(.+), \d+ rooms built; found (\d+) .*eigenvectors ([\d.]+) ms, clustering ([\d.]+) ms", line):
            world = f"{title[1]}, {title[2]} rooms found ({float(title[3]):.0f} ms, {float(title[4]):.0f} ms)"
        elif re.match(r"\| [a-z]+ \|", line) and not line.startswith(("| potential", "| report")):
            yield f"| {world} {line}"
            world = ""


def front(results):
    names = ["gcn", "no-shaping", "look-ahead", "actor-critic-shaped", "actor-critic-unshaped", "planner-frontier", "mbie-eb", "q-learning"]
    yield "| regret ÷ sparse · share of the optimum (fails) | " + " | ".join(f"`{name}`" for name in names) + " |"
    yield "|---|" + "---:|" * len(names)
    for world, result in results:
        cells = [cell(result, name) for name in names]
        yield f"| {world.name} | " + " | ".join(cells) + " |"


def fill(page, tables, commit):
    path = ROOT / page
    text = path.read_text()
    for name, lines in tables.items():
        block = re.compile(rf"(<!-- {name} -->\n).*?(\n<!-- end -->)", re.S)
        table = "\n".join([*lines, "", f"*Commit {commit}.*"])
        text, hits = block.subn(lambda m: m[1] + "\n" + table + "\n" + m[2], text)
        if hits != 1:
            sys.exit(f"{page}: {hits} places marked <!-- {name} -->, want one")
    path.write_text(text)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    out = Path(sys.argv[1])
    commit = (out / "commit").read_text().strip()
    as_it_comes = [arm.name for arm in protocol.ARMS] + protocol.FIXED
    tuned = [f"{arm.name}-tuned" for arm in protocol.ARMS]
    every = parts(out)
    tables, of_method = {}, {}
    done = [name for name in protocol.PARTS if complete(out, name, protocol.PARTS[name])]
    for name in done:
        results = parts(out, [name])
        tables[f"all arms, {name}"] = all_arms(results, as_it_comes)
        if name not in protocol.AS_THEY_COME:
            tables[f"tuned arms, {name}"] = all_arms(results, tuned)
    if done == list(protocol.PARTS):
        tables["default arm"] = default_arm(every)
        tables["profile"] = profile(every, as_it_comes + tuned)
        tables["verdicts"] = verdicts(every, [n for n in as_it_comes if n != "gcn"])
        shown = {f"{name}, goal anywhere" for name in ("four_rooms", "rooms_25x25", "maze_101")}
        shown |= {"holes", "frozen_lake_4", "deep_sea_10"}
        fill("README.md", {"learning": front([(w, r) for w, r in every if w.name in shown])}, commit)
    if (out / "tuned.json").exists():
        tables["tuning"] = tuning(out)
    if complete(out, "times", protocol.TIMES):
        tables["times"] = times(out)
    if complete(out, "sensitivity", protocol.SENSITIVITY):
        tables["sensitivity"] = sensitivity(out)
    if complete(out, "method", protocol.METHOD_WORLDS):
        of_method |= {"factorial": factorial(out), "recipes": recipes(out)}
    if (out / "rooms.txt").exists():
        of_method |= {"transfer": transfer(out), "rooms": rooms(out)}
    fill("docs/learning.md", tables, commit)
    fill("docs/method.md", of_method, commit)


if __name__ == "__main__":
    main()
