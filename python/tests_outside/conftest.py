"""Worlds for tests."""

from __future__ import annotations

import gymnasium as gym
import pytest
import torch


class Corridor(gym.Env):
    """Rooms in a row, of which the last ends the episode. Action 0 goes on, action 1 back."""

    metadata = {"render_modes": []}

    def __init__(self, length: int = 9, limit: int = 200) -> None:
        self.observation_space = gym.spaces.Discrete(length)
        self.action_space = gym.spaces.Discrete(2)
        self.length, self.limit = length, limit

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.room = self.age = 0
        return self.room, {}

    def step(self, action):
        self.room = min(max(self.room + (1 if action == 0 else -1), 0), self.length - 1)
        self.age += 1
        over = self.room == self.length - 1
        return self.room, -1.0, over, not over and self.age >= self.limit, {}


@pytest.fixture
def corridor():
    return Corridor


# More threads than the small networks here can use only wait for each other.
torch.set_num_threads(1)
