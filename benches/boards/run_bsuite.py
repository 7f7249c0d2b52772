"""bsuite where states can be named and rewards are sparse or late: deep sea, deep sea with noise, umbrella, discounting chain.

    benches/boards/run_bsuite.py OUT

Sizes, lengths and seeds are those of bsuite's sweeps, and so is what is counted; EPISODES episodes of each are played where
the sweep has up to 10 000.
"""

import eigentrail
import gymnasium
import numpy as np
from bsuite.environments.deep_sea import DeepSea
from bsuite.environments.discounting_chain import DiscountingChain
from bsuite.environments.umbrella_chain import UmbrellaChain
from bsuite.experiments.deep_sea import sweep as deep_sea_sweep
from bsuite.experiments.discounting_chain import sweep as discounting_sweep
from bsuite.experiments.umbrella_length import sweep as umbrella_sweep
from results import Rows, arguments

EPISODES = 1000
COLUMNS = ["experiment", "setting", "seed", "episodes", "solved_at", "mean_regret", "last_tenth"]


class Board(gymnasium.Env):
    """A bsuite environment as Gymnasium has them. It notes, after each episode, what bsuite counts."""

    def __init__(self, inner, counted):
        self.inner = inner
        self.counted = counted
        self.after = []
        self.earned = 0.0
        spec = inner.observation_spec()
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, spec.shape, spec.dtype)
        self.action_space = gymnasium.spaces.Discrete(inner.action_spec().num_values)

    def reset(self, *, seed=None, options=None):
        return self.inner.reset().observation, {}

    def step(self, action):
        step = self.inner.step(action)
        self.earned += step.reward
        if step.last():
            self.after.append(self.counted(self))
        return step.observation, float(step.reward), step.last(), False, {}


def cell(env, observation):
    """Of the deep sea, the cell; nothing at the bottom."""
    return tuple(int(i) for i in np.flatnonzero(observation))


def without_distractors(env, observation):
    """Of the umbrella, whether it is needed, whether it is there, and the time."""
    return tuple(float(number) for number in observation[0, :3])


def bad_episodes(env):
    return env.inner.bsuite_info()["total_bad_episodes"]


def umbrella_regret(env):
    return env.inner.bsuite_info()["total_regret"]


def chain_regret(env):
    return 1.1 * (len(env.after) + 1) - env.earned


def experiments():
    """Experiment, setting, environment, key, and the length of an episode."""
    for name, calm in (("deep_sea", True), ("deep_sea_stochastic", False)):
        for setting in deep_sea_sweep.SETTINGS:
            size = setting["size"]
            yield name, size, Board(DeepSea(**setting, deterministic=calm, seed=0), bad_episodes), cell, size
    for setting in umbrella_sweep.SETTINGS:
        length = setting["chain_length"]
        yield "umbrella_length", length, Board(UmbrellaChain(**setting, seed=0), umbrella_regret), without_distractors, length
    for setting in discounting_sweep.SETTINGS:
        yield "discounting_chain", setting["mapping_seed"], Board(DiscountingChain(**setting), chain_regret), "obs", 100


def main():
    args = arguments(__doc__, seed=(int, 0, "of the agent"))
    rows = Rows(args.out, "bsuite", COLUMNS, 3)
    for experiment, setting, env, key, length in experiments():
        if not rows.lacks(experiment, setting, args.seed):
            continue
        eigentrail.train(env, key=key, gamma=1.0, max_steps=EPISODES * length, seed=args.seed)
        total = np.array(env.after, dtype=float)
        below = np.flatnonzero(total / np.arange(1, len(total) + 1) < 0.9)  # bsuite: solved when less than 90 % were bad
        solved = int(below[0]) + 1 if len(below) and experiment.startswith("deep_sea") else None
        tenth = len(total) // 10
        last = (total[-1] - total[-1 - tenth]) / tenth
        rows.add(experiment, setting, args.seed, len(total), solved, round(total[-1] / len(total), 4), round(last, 4))


if __name__ == "__main__":
    main()
