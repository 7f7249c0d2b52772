"""TopoGym-v1, the 189 worlds of its tune split: steps to the first goal, at most a million.

    benches/boards/run_topogym.py OUT

A world is run until its goal is reached. Worlds are made once and kept in OUT/worlds, since TopoGym certifies the topology of
each one, which takes longer than most runs. What nothing reads is not computed: the key names states by what the world
is, so no view is drawn, and no statistics of visited cells are kept.
"""

import csv
import pathlib
import pickle
import time

import eigentrail
import gymnasium
import numpy as np
import topogym  # noqa: F401 (registers its worlds)
from results import Rows, arguments

SPLIT = pathlib.Path(__file__).with_name("topogym_tune.csv")
COLUMNS = ["slice", "family", "unit", "world_seed", "seed", "optimal", "reachable", "first_goal", "steps", "states", "seconds"]


class Reached(Exception):
    """The goal was entered."""


class UntilGoal(gymnasium.Wrapper):
    """Counts steps, and raises when one of them enters the goal."""

    steps = 0

    def step(self, action):
        result = self.env.step(action)
        self.steps += 1
        if result[2] and result[1] >= 1.0:
            raise Reached
        return result


def world(row, kept):
    """The environment of a row of the split, without views."""
    options = {"size": int(row["size"])} if int(row["size"]) else {}
    env = gymnasium.make(
        row["template_id"],
        seed=int(row["seed"]),
        placement_jitter=int(row["placement_jitter"]),
        max_steps=int(row["horizon"]),
        disable_env_checker=True,
        **options,
    )
    inner = env.unwrapped
    inner._fixed_layout = layout(row, inner, kept)
    assert len(inner._fixed_layout.free_cells) == int(row["n_free_cells"])
    nothing = np.zeros(inner.observation_space.shape, inner.observation_space.dtype)
    inner._obs = lambda: nothing
    inner._step_info = inner._reset_info = lambda cell: {}
    return env


def layout(row, inner, kept):
    file = kept / f"{row['unit']}@{row['seed']}.pkl"
    if not file.exists():
        made = inner._generate(int(row["seed"]))
        file.write_bytes(pickle.dumps(made))
    return pickle.loads(file.read_bytes())


def can_be_reached(env):
    """Whether a way to the goal fits into an episode: TopoGym's own search over cells and headings, hazards left out."""
    env.reset(seed=0)
    inner = env.unwrapped
    optimal = inner.optimal_actions()
    return optimal is not None and optimal <= inner._max_steps


def first_goal(row, kept, seed, max_steps):
    """Steps to the goal (none if it was not reached), steps taken, and states known where it was not."""
    env = UntilGoal(world(row, kept))
    try:
        result = eigentrail.train(env, key="topogym", gamma=1.0, max_steps=max_steps, seed=seed)
    except Reached:
        return env.steps, env.steps, None
    return None, env.steps, result.nodes


def main():
    args = arguments(__doc__, seed=(int, 0, "of the agent"), steps=(int, 1_000_000, "at most"))
    kept = pathlib.Path(args.out) / "worlds"
    kept.mkdir(parents=True, exist_ok=True)
    rows = Rows(args.out, "topogym", COLUMNS, 5)
    with open(SPLIT, newline="") as file:
        split = sorted(csv.DictReader(file), key=lambda row: int(row["n_free_cells"]))
    for row in split:
        names = (row["slice"], row["family"], row["unit"], row["seed"], args.seed)
        if rows.lacks(*names):
            reachable = can_be_reached(world(row, kept))
            begun = time.process_time()
            goal, steps, states = first_goal(row, kept, args.seed, args.steps)
            seconds = round(time.process_time() - begun, 1)
            rows.add(*names, row["optimal_actions"], int(reachable), goal, steps, states, seconds)


if __name__ == "__main__":
    main()
