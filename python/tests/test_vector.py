"""Vector environments, against the wrapper of one environment."""

from __future__ import annotations

import eigentrail
import gymnasium as gym
import minigrid  # noqa: F401 (registers its worlds)
import numpy as np
import pytest
from conftest import Corridor
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv

MODES = [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP, AutoresetMode.DISABLED]
ACTIONS = [int(a) for a in np.random.default_rng(3).integers(4, size=900) > 0]  # on, with a step back now and then
ACTIONS = [1 - a for a in ACTIONS]


def alone() -> list[tuple[float, float, bool, int]]:
    """What the wrapper of one environment says to the actions: reward, shaping, end, node."""
    env = eigentrail.Shaped(Corridor(limit=12), gamma=0.95)
    env.reset(seed=0)
    told = []
    for action in ACTIONS:
        _, reward, terminated, truncated, info = env.step(action)
        told.append((float(reward), info["shaping"], terminated or truncated, info["node"]))
        if terminated or truncated:
            env.reset()
    return told


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("key", ["obs", lambda env: env.unwrapped.room])
def test_one_environment_in_any_mode_is_the_environment_alone(mode, key):
    envs = SyncVectorEnv([lambda: Corridor(limit=12)], autoreset_mode=mode)
    envs = eigentrail.ShapedVec(envs, key=key, gamma=0.95)
    envs.reset(seed=0)
    told, actions, ended = [], iter(ACTIONS), False
    while len(told) < len(ACTIONS):
        if ended and mode is AutoresetMode.DISABLED:
            envs.reset(options={"reset_mask": np.array([True])})
        resets = ended and mode is AutoresetMode.NEXT_STEP
        action = 0 if resets else next(actions)
        _, rewards, terminated, truncated, info = envs.step(np.array([action]))
        ended = bool(terminated[0] or truncated[0])
        if resets:
            assert info["shaping"][0] == 0.0 == rewards[0] and info["node"][0] == 0
        else:
            node = -1 if ended and mode is AutoresetMode.SAME_STEP else int(info["node"][0])
            told.append((float(rewards[0]), float(info["shaping"][0]), ended, node))
    expected = alone()
    for one, other in zip(told, expected, strict=True):
        assert one[:3] == other[:3]
        assert one[3] in (other[3], -1)
    assert sum(row[2] for row in told) > 20 and any(row[1] for row in told)


@pytest.mark.parametrize("mode", MODES[:2])
def test_shaping_telescopes_for_every_walker(mode):
    gamma, number = 0.9, 3
    envs = SyncVectorEnv([lambda: Corridor(limit=25)] * number, autoreset_mode=mode)
    envs = eigentrail.ShapedVec(envs, gamma=gamma, exploration={"potential_advice": 20.0})
    _, info = envs.reset(seed=0)
    start, total, age, ends = info["phi"].copy(), np.zeros(number), np.zeros(number), 0
    was_over = np.zeros(number, dtype=bool)
    for _ in range(600):
        _, _, terminated, truncated, info = envs.step(info["advice"].argmax(axis=1))
        for i in range(number):
            if was_over[i] and mode is AutoresetMode.NEXT_STEP:
                start[i], total[i], age[i], was_over[i] = info["phi"][i], 0.0, 0, False
                continue
            total[i] += gamma ** age[i] * info["shaping"][i]
            age[i] += 1
            if terminated[i]:
                ends += 1
                assert total[i] == pytest.approx(-start[i], abs=1e-9)
            if terminated[i] or truncated[i]:
                was_over[i] = True
                if mode is AutoresetMode.SAME_STEP:
                    start[i], total[i], age[i] = info["phi"][i], 0.0, 0
    assert ends > 20


def test_environments_elsewhere_are_named_by_their_observations():
    def one(kind, mode):
        envs = kind([lambda: Corridor(limit=20)] * 2, autoreset_mode=mode)
        return eigentrail.ShapedVec(envs, key="obs", gamma=1.0)

    for mode in MODES[:2]:
        here, there = one(SyncVectorEnv, mode), one(AsyncVectorEnv, mode)
        here.reset(seed=0)
        there.reset(seed=0)
        rng = np.random.default_rng(1)
        for _ in range(200):
            actions = (rng.random(2) < 0.2).astype(np.int64)
            said, heard = here.step(actions), there.step(actions)
            np.testing.assert_array_equal(said[1], heard[1])
            for name in ("shaping", "phi", "node", "advice", "graph_nodes"):
                np.testing.assert_array_equal(said[-1][name], heard[-1][name])
        there.close()


def test_keys_that_look_into_environments_need_them_here():
    envs = AsyncVectorEnv([lambda: Corridor()])
    with pytest.raises(TypeError, match="the key has to look into the environments of AsyncVectorEnv"):
        eigentrail.ShapedVec(envs, key=lambda env: env.unwrapped.room)
    envs.close()


def test_walkers_in_one_minigrid_world_share_its_graph():
    envs = gym.make_vec("MiniGrid-Empty-5x5-v0", num_envs=3, vectorization_mode="sync")
    envs = eigentrail.ShapedVec(envs, key="minigrid", gamma=0.99)
    _, info = envs.reset(seed=0)
    for _ in range(300):
        _, _, _, _, info = envs.step(info["advice"].argmax(axis=1))
    assert len({id(engine) for engine in envs.engines}) == 1
    assert (info["graph_nodes"] == info["graph_nodes"][0]).all() and info["graph_nodes"][0] > 10
    assert info["_shaping"].all() and info["_advice"].shape == (3,)


def test_a_mask_begins_the_episodes_that_it_names():
    envs = SyncVectorEnv([lambda: Corridor()] * 3, autoreset_mode=AutoresetMode.DISABLED)
    envs = eigentrail.ShapedVec(envs, gamma=1.0)
    envs.reset(seed=0)
    envs.step(np.array([0, 0, 0]))
    options = {"reset_mask": np.array([False, True, False])}
    _, info = envs.reset(options=options)
    assert "reset_mask" in options
    assert info["node"].tolist() == [1, 0, 1]
    _, _, _, _, info = envs.step(np.array([0, 0, 0]))
    assert info["node"].tolist() == [2, 1, 2]
