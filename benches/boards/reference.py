"""Boards of the field against their own implementations: same transitions, rewards and ends.

    python -m venv V && V/bin/pip install -r benches/boards/requirements.txt
    V/bin/python benches/boards/reference.py

Every state, action and outcome of Gymnasium's tables (FrozenLake, CliffWalking, Taxi) is compared, and every cell and
move of bsuite's deep sea. Of its stochastic form each cell and move is tried SAMPLES times: frequencies, means and standard
deviations must lie within BOUND standard errors of ours, and what cannot happen must not have happened. River swim has no implementation on PyPI; its optimal returns are those of the literature.
"""

import collections
import csv
import math
import pathlib
import subprocess
import sys

SAMPLES = 20_000
BOUND = 5.0  # one of 1.7 million comparisons is beyond it by chance; there are some hundreds

ROOT = pathlib.Path(__file__).resolve().parents[2]


def ours(kind, **env):
    """The world of `[env] kind = kind`: {(from, action): {to: [probability, mean reward]}}, starts, ends, limit,
    {state: standard deviation of what a step from there pays beside}."""
    lines = [f'kind = "{kind}"'] + [f"{key} = {value}" for key, value in env.items()]
    file = ROOT / "target" / "board.toml"
    file.parent.mkdir(exist_ok=True)
    file.write_text("[env]\n" + "\n".join(lines) + "\n")
    program = ["cargo", "run", "--quiet", "--release", "--locked", "--example", "world_as_edges", "--", str(file)]
    text = subprocess.run(program, cwd=ROOT, check=True, capture_output=True, text=True).stdout
    notes, table = collections.defaultdict(list), []
    for line in text.splitlines():
        if line.startswith("# "):
            key, value = line[2:].split(" ", 1)
            notes[key].append(value)
        else:
            table.append(line)
    outcomes = (((r["from"], int(r["action"])), r["to"], float(r["probability"]), float(r["reward"]))
                for r in csv.DictReader(table))
    noise = {state: float(deviation) for deviation, state in (note.split(" ", 1) for note in notes["noise"])}
    return merged(outcomes), set(notes["start"]), set(notes["end"]), int(notes["max_steps"][0]), noise


def merged(outcomes):
    """Outcomes that lead to the same state are one."""
    table = collections.defaultdict(lambda: collections.defaultdict(lambda: [0.0, 0.0]))
    for pair, to, probability, reward in outcomes:
        table[pair][to][0] += probability
        table[pair][to][1] += probability * reward
    return table


def theirs(env, name):
    """The table `P` of a toy-text world, terminal states left out."""
    table = env.unwrapped.P
    ends = {to for rows in table.values() for row in rows.values() for _, to, _, end in row if end}
    return merged(((name(s), a), name(int(to)), p, r)
                  for s, rows in table.items() if s not in ends
                  for a, row in rows.items() for p, to, r, _ in row), {name(int(e)) for e in ends}


def require_equal(board, left, right):
    if left.keys() != right.keys():
        sys.exit(f"{board}: other pairs: {sorted(left.keys() ^ right.keys())[:5]}")
    for pair, row in left.items():
        other = right[pair]
        same = row.keys() == other.keys() and all(
            abs(a - b) < 1e-9 for to in row for a, b in zip(row[to], other[to]))
        if not same:
            sys.exit(f"{board}, {pair}: {dict(row)} is not {dict(other)}")
    print(f"{board}: {len(left)} pairs of state and action are the same")


def gymnasium_boards():
    import gymnasium

    def cell(cols):
        return lambda s: f"[{s // cols}, {s % cols}]"

    def yard(s):
        places = ["red", "green", "yellow", "blue", "riding"]
        rest, destination = divmod(s, 4)
        rest, passenger = divmod(rest, 5)
        return f"[{rest // 5}, {rest % 5}] {places[passenger]} to {places[destination]}"

    for size, name in ((4, "FrozenLake-v1"), (8, "FrozenLake8x8-v1")):
        env = gymnasium.make(name)
        compare(f"frozen lake {size}", ours("frozen-lake", size=size), theirs(env, cell(size)), env)
    env = gymnasium.make("CliffWalking-v1")
    compare("cliff", ours("cliff"), theirs(env, cell(12)), env)
    env = gymnasium.make("Taxi-v4")
    compare("taxi", ours("taxi"), theirs(env, yard), env)


def compare(board, mine, others, env):
    """Only what can be reached matters: Gymnasium's tables hold states inside the cliff and taxis that are done."""
    table, starts, ends, limit, noise = mine
    assert not noise
    other, other_ends = others
    reached, waiting = set(), list(starts)
    while waiting:
        state = waiting.pop()
        if state in reached or state in ends:
            reached.add(state)
            continue
        reached.add(state)
        waiting += [to for (s, _), row in table.items() if s == state for to in row]
    within = lambda t: {pair: row for pair, row in t.items() if pair[0] in reached - ends}
    require_equal(board, within(table), within(other))
    if ends & reached != other_ends & reached:
        sys.exit(f"{board}: other ends: {(ends ^ other_ends) & reached}")
    if env.spec.max_episode_steps not in (None, limit):
        sys.exit(f"{board}: cut off after {limit} steps, not {env.spec.max_episode_steps}")


def deep_sea(size):
    from bsuite.environments.deep_sea import DeepSea

    table, starts, ends, limit, noise = ours("deep-sea", size=size)
    env = DeepSea(size, mapping_seed=1)
    assert (starts, ends, limit, noise) == ({"[0, 0]"}, {"end"}, size, {})
    moves = 0
    for (state, _), _ in table.items():
        row, col = map(int, state.strip("[]").split(", "))
        rows = [table[state, action] for action in (0, 1)]
        found = sorted((to, round(reward, 9)) for r in rows for to, (_, reward) in r.items())
        expected = []
        for action in (0, 1):
            env.reset()
            env._row, env._column = row, col
            step = env.step(action)
            last = step.last()
            to = "end" if last else f"[{env._row}, {env._column}]"
            expected.append((to, round(float(step.reward), 9)))
        if found != sorted(expected):
            sys.exit(f"deep sea {size}, {state}: {found} is not {sorted(expected)}")
        moves += 1
    print(f"deep sea {size}: {moves} pairs of cell and action are the same")


def stochastic_deep_sea(size):
    from bsuite.environments.deep_sea import DeepSea

    table, starts, ends, limit, noise = ours("deep-sea", size=size, stochastic="true")
    env = DeepSea(size, deterministic=False, seed=0, mapping_seed=1)
    assert (starts, ends, limit) == ({"[0, 0]"}, {"end"}, size)
    comparisons, furthest = 0, 0.0
    for row in range(size):
        for col in range(row + 1):
            state = f"[{row}, {col}]"
            rows = [table[state, action] for action in (0, 1)]
            right = max((0, 1), key=lambda a: -sum(p_r for _, p_r in rows[a].values()) if col < size - 1 else
                        sum(p_r for _, p_r in rows[a].values()))
            for goes_right in (False, True):
                mine = rows[right if goes_right else 1 - right]
                at_right = int(env._action_mapping[row, col])
                seen, rewards = collections.Counter(), []
                for _ in range(SAMPLES):
                    env._row, env._column = row, col
                    step = env._step(at_right if goes_right else 1 - at_right)
                    seen["end" if step.last() else f"[{env._row}, {env._column}]"] += 1
                    rewards.append(float(step.reward))
                mean = sum(rewards) / SAMPLES
                deviation = math.sqrt(sum((r - mean) ** 2 for r in rewards) / (SAMPLES - 1))
                sigma = noise.get(state, 0.0)
                off = []  # differences and their standard errors
                for to in seen.keys() | mine.keys():
                    p = mine[to][0] if to in mine else 0.0
                    off.append((seen[to] / SAMPLES - p, math.sqrt(p * (1 - p) / SAMPLES)))
                off.append((mean - sum(p_r for _, p_r in mine.values()), sigma / math.sqrt(SAMPLES)))
                off.append((deviation - sigma, sigma / math.sqrt(2 * SAMPLES)))
                for difference, error in off:
                    if abs(difference) > BOUND * error + 1e-9:
                        sys.exit(f"stochastic deep sea {size}, {state}: {difference} is more than {BOUND} x {error}")
                    furthest = max(furthest, abs(difference) / error if error else 0.0)
                    comparisons += 1
    print(f"stochastic deep sea {size}: {comparisons} frequencies, means and deviations of {SAMPLES} samples are within "
          f"{furthest:.1f} standard errors")


if __name__ == "__main__":
    gymnasium_boards()
    for size in (2, 10, 20):
        deep_sea(size)
    for size in (2, 10):
        stochastic_deep_sea(size)
