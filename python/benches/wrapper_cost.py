"""What the wrapper costs beyond the environment: microseconds a step, with as many states known as are asked for.

    python python/benches/wrapper_cost.py [STATES]

The environment answers from memory, so that all that is measured is the key, the engine and `info`. States are poses and
doors of a made-up MiniGrid world, named by the key "minigrid".
"""

from __future__ import annotations

import sys
import time
import warnings

import eigentrail
import gymnasium as gym
import minigrid
import numpy as np


class Replayed(gym.Env):
    """A MiniGrid world whose agent is put where a long walk over all poses of a big grid has been."""

    def __init__(self, states: int) -> None:
        self.world = gym.make("MiniGrid-DoorKey-8x8-v0").unwrapped
        self.world.reset(seed=0)
        self.action_space = self.world.action_space
        self.observation_space = gym.spaces.Discrete(1)
        self.side = int(np.ceil(np.sqrt(states / 4)))
        self.at = 0

    @property
    def unwrapped(self):
        return self.world

    def reset(self, *, seed=None, options=None):
        return 0, {}

    def step(self, action):
        self.at = (self.at + 1) % (4 * self.side * self.side)
        place, self.world.agent_dir = divmod(self.at, 4)
        self.world.agent_pos = divmod(place, self.side)
        return 0, 0.0, False, False, {}


def microseconds(env: gym.Env, steps: int) -> float:
    begin = time.process_time()
    for _ in range(steps):
        env.step(2)
    return (time.process_time() - begin) / steps * 1e6


def main(states: int) -> None:
    warnings.simplefilter("ignore")
    plain = Replayed(states)
    env = eigentrail.Shaped(plain, key="minigrid", gamma=0.99)
    env.reset()
    all_states = 4 * plain.side * plain.side
    microseconds(env, all_states)  # all of them become known, and features are refreshed on the way
    steps = 100_000
    bare, wrapped = microseconds(plain, steps), microseconds(env, steps)
    print(f"minigrid {minigrid.__version__}, {env.engine.num_nodes} states: {wrapped - bare:.2f} µs a step beyond the environment")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100_000)
