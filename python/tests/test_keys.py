"""The keys of MiniGrid, against the whole grid as MiniGrid itself encodes it."""

from __future__ import annotations

import gymnasium as gym
import minigrid  # noqa: F401 (registers its worlds)
import numpy as np
import pytest
from eigentrail.keys import Namer
from minigrid.core.world_object import Ball, Box, Key

WORLDS = [
    "MiniGrid-DoorKey-6x6-v0",
    "MiniGrid-KeyCorridorS3R2-v0",
    "MiniGrid-UnlockPickup-v0",
    "MiniGrid-ObstructedMaze-1Dlhb-v0",
    "MiniGrid-Dynamic-Obstacles-6x6-v0",
    "MiniGrid-PutNear-6x6-N2-v0",
    "MiniGrid-MultiRoom-N2-S4-v0",
]


def whole(env: gym.Env):
    """All that a MiniGrid world is, at a price: cells with what is in boxes, pose, and what is carried."""
    world = env.unwrapped

    def told(thing):
        if thing is None:
            return None
        return (thing.type, thing.color, tuple(thing.encode()), told(thing.contains))

    x, y = world.agent_pos
    return (tuple(map(told, world.grid.grid)), (int(x), int(y), world.agent_dir), told(world.carrying))


@pytest.mark.parametrize("name", WORLDS)
def test_names_differ_where_the_worlds_do(name):
    env = gym.make(name).unwrapped
    namer = Namer("minigrid")
    rng = np.random.default_rng(0)
    states: dict[bytes, object] = {}
    names: dict[object, set[bytes]] = {}
    env.reset(seed=5)
    namer.reset(env)
    for _ in range(4000):
        # Forward, pick up, drop and toggle more often than turns: things are moved about.
        _, _, terminated, truncated, _ = env.step(int(rng.choice(env.action_space.n)))
        state, given = whole(env), namer(env, None)
        assert states.setdefault(given, state) == state, "one name, two states"
        names.setdefault(state, set()).add(given)
        if terminated or truncated:
            env.reset(seed=5)
            namer.reset(env)
    assert len(names) > 30
    # Things of one kind and colour can change places, so that a state has a few names; it must not have many.
    assert np.mean([len(given) for given in names.values()]) < 1.5


def test_boxes_that_are_opened_give_their_content_free():
    env = gym.make("MiniGrid-Empty-8x8-v0").unwrapped
    env.reset(seed=0)
    env.put_obj(Box("red", contains=Key("blue")), 3, 1)
    env.put_obj(Ball("green"), 5, 5)
    namer = Namer("minigrid")
    namer.reset(env)
    forward, pickup, toggle = env.actions.forward, env.actions.pickup, env.actions.toggle
    seen = [namer(env, None)]
    for action in (forward, toggle, pickup, env.actions.drop):
        env.step(action)
        seen.append(namer(env, None))
    assert len(set(seen)) == 5 or seen[2] == seen[4]
    assert len(set(seen[:4])) == 4


def test_the_pose_alone_does_not_see_doors():
    env = gym.make("MiniGrid-DoorKey-5x5-v0")
    env.reset(seed=0)
    namer = Namer("minigrid-pose")
    layout = namer.reset(env)
    before = namer(env, None)
    for thing in env.unwrapped.grid.grid:
        if thing is not None and thing.type == "door":
            thing.is_open = True
    assert namer(env, None) == before
    assert namer.reset(env) != layout, "the layout is all of the grid as an episode begins"
