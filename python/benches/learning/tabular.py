"""Tabular Q-learning on MiniGrid worlds with a fixed layout: wrapped, unwrapped, optimistic, and with a bonus for novelty.

    python python/benches/learning/tabular.py [--tune] [--seeds 10] [--cap 1000000] [--worlds DoorKey-8x8 …] [--json FILE]

Counted are environment steps until the goal was first reached, and until it was reached in 18 of the last 20 episodes, exploration
included. Runs that do not come there end at the cap, and count as the cap. `--tune` tries twelve settings for every arm on three
seeds of their own and a smaller world of another layout, and prints the best: those are the settings below.
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
from typing import NamedTuple

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
TUNING_WORLD, TUNING_LAYOUT, TUNING_CAP, TUNING_SEEDS = "MiniGrid-DoorKey-6x6-v0", 1, 100_000, range(1_000_000, 1_000_003)
# Advice until the first success; always; always, and to the goal as well; never; until the first success, and raw rewards.
WRAPPED = ("wrapped", "wrapped, advice always", "wrapped, led to the goal", "wrapped, no advice", "advice alone")
ARMS = ("unwrapped", "optimistic", "count bonus", *WRAPPED)


class Setting(NamedTuple):
    """Learning rate, share of random actions, and what else the arm has: the weight of the bonus, of
    `potential_advice`, or the values at first of the optimistic one."""

    rate: float
    random: float
    weight: float = 0.0


SETTINGS: dict[str, Setting] = {
    "unwrapped": Setting(0.1, 0.3),
    "optimistic": Setting(1.0, 0.02, 0.01),
    "count bonus": Setting(1.0, 0.02, 0.001),
    "wrapped": Setting(0.5, 0.02),
    "wrapped, advice always": Setting(0.1, 0.1),
    "wrapped, led to the goal": Setting(0.5, 0.0, 20.0),
    "wrapped, no advice": Setting(0.5, 0.02),  # these two were not tuned: they have the setting of "wrapped"
    "advice alone": Setting(0.5, 0.02),
}


class Table:
    """Action values, all the same at first; among equally good actions a random one is chosen."""

    def __init__(self, num_actions: int, at_first: float, rng: np.random.Generator) -> None:
        self.num_actions = num_actions
        self.at_first = at_first
        self.rows: list[list[float]] = []
        self.counts: list[list[int]] = []
        self.draws = iter(())
        self.rng = rng

    def row(self, state: int) -> list[float]:
        while len(self.rows) <= state:
            self.rows.append([self.at_first] * self.num_actions)
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


def run(plain: gym.Env, arm: str, setting: Setting, seed: int, cap: int) -> tuple[int | None, int | None]:
    """Steps to the first success, and to 18 successes in 20 episodes."""
    rate, random_share, weight = setting
    env = plain
    if arm in WRAPPED:
        leads = {"potential_advice": weight}
        reward_kind = "raw" if arm == "advice alone" else "shaped"
        env = eigentrail.Shaped(plain, key="obs", gamma=GAMMA, seed=seed, reward=reward_kind, exploration=leads)
    advised = arm in WRAPPED and arm != "wrapped, no advice"
    # What was never tried is worth what bonuses alone could be: from 0 a learner with bonuses would stay with what it has tried.
    at_first = {"optimistic": weight, "count bonus": weight / (1.0 - GAMMA)}.get(arm, 0.0)
    table = Table(int(env.action_space.n), at_first, np.random.default_rng(seed))
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
                advised = advised and arm not in ("wrapped", "advice alone")
            lately.append(success)
            if sum(lately) >= 18:
                return first, step
            state, info = env.reset()
            row = table.row(state)
    return first, None


def settings_of(arm: str) -> list[Setting]:
    """Twelve for every arm."""
    weights = {
        "optimistic": (0.01, 0.1, 1.0),
        "count bonus": (0.0001, 0.001, 0.01),
        "wrapped, led to the goal": (5.0, 20.0, 100.0),
    }
    if arm in weights:
        return [Setting(*some) for some in itertools.product((0.5, 1.0), (0.0, 0.02), weights[arm])]
    shares = (0.02, 0.1, 0.3) if arm in ("unwrapped", "wrapped, no advice") else (0.0, 0.02, 0.1)
    return [Setting(*some) for some in itertools.product((0.1, 0.3, 0.5, 1.0), shares)]


def tuned(plain: gym.Env, arm: str) -> Setting:
    """The setting with the fewest steps to 18 of 20, to the first success where that is the same."""

    def cost(setting: Setting) -> tuple[float, float]:
        results = [run(plain, arm, setting, seed, TUNING_CAP) for seed in TUNING_SEEDS]
        first, often = (float(np.mean([TUNING_CAP if r[i] is None else r[i] for r in results])) for i in (0, 1))
        print(f"  {arm}: {tuple(setting)} {often:,.0f} {first:,.0f}", file=sys.stderr, flush=True)
        return often, first

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
    parser.add_argument("--cap", type=int, default=1_000_000)
    parser.add_argument("--worlds", nargs="+", default=list(WORLDS), choices=list(WORLDS))
    parser.add_argument("--arms", nargs="+", default=list(ARMS), choices=list(ARMS))
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    warnings.simplefilter("ignore")
    if asked.tune:
        plain = Remembered(TUNING_WORLD, TUNING_LAYOUT)
        for arm in asked.arms:
            print(f'    "{arm}": {tuned(plain, arm)},', flush=True)
        return
    results = []
    for world in asked.worlds:
        compare(WORLDS[world], LAYOUT)
        plain = Remembered(WORLDS[world], LAYOUT)
        for arm in asked.arms:
            begin = time.time()
            found = [run(plain, arm, SETTINGS[arm], seed, asked.cap) for seed in range(asked.seeds)]
            first, often = zip(*found, strict=True)
            print(f"| {world} | {arm} | {told(list(first), asked.cap)} | {told(list(often), asked.cap)} |", flush=True)
            print(f"  {time.time() - begin:.0f} s, {len(plain.states)} states met", file=sys.stderr, flush=True)
            results.append({"world": world, "arm": arm, "setting": SETTINGS[arm], "first": first, "often": often})
            if asked.json:
                asked.json.write_text(json.dumps({"cap": asked.cap, "results": results}, indent=1) + "\n")


if __name__ == "__main__":
    main()
