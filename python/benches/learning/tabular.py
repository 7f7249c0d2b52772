"""Tabular Q-learning on MiniGrid worlds with a fixed layout: wrapped, unwrapped, and with a bonus for novelty.

    python python/benches/learning/tabular.py [--tune] [--seeds 10] [--cap 100000] [--worlds DoorKey-8x8 …] [--json FILE]

Counted are environment steps until the goal was first reached, and until it was reached in 18 of the last 20 episodes, exploration
included. Runs that do not come there end at the cap, and count as the cap. The settings below were
chosen by hand, once for all worlds; `--tune` tries a grid of them for every arm on three seeds of its own and prints the best.
"""

from __future__ import annotations

import argparse
import itertools
import json
import sys
import time
import warnings
from collections import deque
from pathlib import Path

import eigentrail
import gymnasium as gym
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from remembered import Remembered, compare  # noqa: E402

GAMMA = 0.99
LAYOUT = 0
WORLDS = {
    "DoorKey-8x8": "MiniGrid-DoorKey-8x8-v0",
    "MultiRoom-N6": "MiniGrid-MultiRoom-N6-v0",
    "KeyCorridorS3R3": "MiniGrid-KeyCorridorS3R3-v0",
}
ARMS = ("unwrapped", "count bonus", "wrapped", "wrapped, no advice", "advice alone")
RATES, RANDOM, BONUSES = (0.2, 0.5, 1.0), (0.02, 0.1, 0.3), (0.001, 0.01, 0.1, 1.0)
# Learning rate, share of random actions, and weight of the bonus.
PLAIN = (0.5, 0.1, 0.0)
SETTINGS: dict[str, tuple[float, float, float]] = {
    "unwrapped": PLAIN,
    "count bonus": (0.5, 0.02, 0.01),
    "wrapped": (0.5, 0.02, 0.0),
    "wrapped, no advice": PLAIN,
    "advice alone": (0.5, 0.02, 0.0),
}


class Table:
    """Action values, 0 at first; among equally good actions a random one is chosen."""

    def __init__(self, num_actions: int, rng: np.random.Generator) -> None:
        self.num_actions = num_actions
        self.rows: list[list[float]] = []
        self.counts: list[list[int]] = []
        self.draws = iter(())
        self.rng = rng

    def row(self, state: int) -> list[float]:
        while len(self.rows) <= state:
            self.rows.append([0.0] * self.num_actions)
            self.counts.append([0] * self.num_actions)
        return self.rows[state]

    def draw(self) -> float:
        try:
            return next(self.draws)
        except StopIteration:
            self.draws = iter(self.rng.random(1 << 16).tolist())
            return next(self.draws)

    def choose(self, values: list[float], random_share: float) -> int:
        if random_share > 0 and self.draw() < random_share:
            return int(self.draw() * self.num_actions)
        best = max(values)
        if values.count(best) == 1:
            return values.index(best)
        ties = [action for action, value in enumerate(values) if value == best]
        return ties[int(self.draw() * len(ties))]


def run(plain: gym.Env, arm: str, setting: tuple[float, float, float], seed: int, cap: int) -> tuple[int | None, int | None]:
    """Steps to the first success, and to 18 successes in 20 episodes."""
    rate, random_share, weight = setting
    wraps = arm not in ("unwrapped", "count bonus")
    reward_kind = "raw" if arm == "advice alone" else "shaped"
    env = eigentrail.Shaped(plain, key="obs", gamma=GAMMA, seed=seed, reward=reward_kind) if wraps else plain
    advised = arm in ("wrapped", "advice alone")
    table = Table(int(env.action_space.n), np.random.default_rng(seed))
    first, lately = None, deque(maxlen=20)
    state, info = env.reset(seed=seed)
    row = table.row(state)
    for step in range(1, cap + 1):
        values = (info["advice"] + row).tolist() if advised else row
        action = table.choose(values, random_share)
        after, reward, terminated, truncated, info = env.step(action)
        after_row = table.row(after)
        target = reward if terminated else reward + GAMMA * max(after_row)
        if arm == "count bonus":
            counts = table.counts[state]
            counts[action] += 1
            target += weight / counts[action] ** 0.5
        row[action] += rate * (target - row[action])
        state, row = after, after_row
        if terminated or truncated:
            success = terminated and info.get("extrinsic_reward", reward) > 0
            if success and first is None:
                first = step
            lately.append(success)
            if sum(lately) >= 18:
                return first, step
            state, info = env.reset()
            row = table.row(state)
    return first, None


def settings_of(arm: str) -> list[tuple[float, float, float]]:
    if arm == "count bonus":
        return list(itertools.product(RATES, (0.0, *RANDOM[:2]), BONUSES))
    return list(itertools.product(RATES, RANDOM, (0.0,)))


def tuned(plain: gym.Env, arm: str, cap: int) -> tuple[float, float, float]:
    """The setting with the fewest steps to 18 of 20, to the first success where that is the same."""

    def cost(setting: tuple[float, float, float]) -> tuple[float, float]:
        results = [run(plain, arm, setting, seed, cap) for seed in (1000, 1001, 1002)]
        return tuple(float(np.mean([cap if r[i] is None else r[i] for r in results])) for i in (1, 0))

    return min(settings_of(arm), key=cost)


def told(steps: list[int | None], cap: int) -> str:
    """Median [least, largest]; what was not reached counts as the cap."""
    numbers = [cap if step is None else step for step in steps]
    missed = sum(step is None for step in steps)
    text = f"{np.median(numbers):,.0f} [{min(numbers):,} to {max(numbers):,}]"
    return text + (f", {missed} of {len(steps)} never" if missed else "")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tune", action="store_true")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--cap", type=int, default=100_000)
    parser.add_argument("--worlds", nargs="+", default=list(WORLDS), choices=list(WORLDS))
    parser.add_argument("--arms", nargs="+", default=list(ARMS), choices=list(ARMS))
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    results = []
    for world in asked.worlds:
        compare(WORLDS[world], LAYOUT)
        plain = Remembered(WORLDS[world], LAYOUT)
        for arm in asked.arms:
            begin = time.time()
            if asked.tune:
                setting = tuned(plain, arm, asked.cap)
                print(f"{world} | {arm} | {setting}", flush=True)
            else:
                setting = SETTINGS[arm]
                found = [run(plain, arm, setting, seed, asked.cap) for seed in range(asked.seeds)]
                first, often = zip(*found, strict=True)
                print(f"{world} | {arm} | {told(list(first), asked.cap)} | {told(list(often), asked.cap)}", flush=True)
                results.append({"world": world, "arm": arm, "setting": setting, "first": first, "often": often})
            print(f"  {time.time() - begin:.0f} s", file=sys.stderr)
    if asked.json:
        asked.json.write_text(json.dumps({"cap": asked.cap, "results": results}, indent=1) + "\n")


if __name__ == "__main__":
    main()
