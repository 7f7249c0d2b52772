"""Wrappers in files, and copies of vector environments."""

from __future__ import annotations

import copy

import eigentrail
import gymnasium as gym
import minigrid  # noqa: F401 (registers its worlds)
import numpy as np
import pytest
from conftest import Corridor
from gymnasium.vector import SyncVectorEnv
from minigrid.wrappers import ReseedWrapper


def walked(env: gym.Env, steps: int, seed: int = 0) -> list[float]:
    """Shaping of a walk that follows advice two times out of three."""
    rng = np.random.default_rng(seed)
    _, info = env.reset(seed=seed)
    shaping = []
    for _ in range(steps):
        action = int(info["advice"].argmax()) if rng.random() < 0.67 else int(rng.integers(env.action_space.n))
        _, _, terminated, truncated, info = env.step(action)
        shaping.append(info["shaping"])
        if terminated or truncated:
            _, info = env.reset()
    return shaping


def test_a_wrapper_goes_on_from_its_file(tmp_path):
    env = eigentrail.Shaped(Corridor(), gamma=0.9, seed=3, exploration={"potential_advice": 20.0})
    assert any(walked(env, 200))
    env.save(tmp_path / "worlds")
    again = eigentrail.Shaped.load(tmp_path / "worlds", Corridor())
    assert (again.gamma, again.engine.steps) == (0.9, 200)
    assert walked(again, 100, 1) == walked(env, 100, 1)


def test_each_layout_is_in_the_file(tmp_path):
    def world():
        return ReseedWrapper(gym.make("MiniGrid-FourRooms-v0"), seeds=(0, 1))

    env = eigentrail.Shaped(world(), key="minigrid", gamma=0.99)
    walked(env, 500)
    env.save(tmp_path / "worlds")
    again = eigentrail.Shaped.load(tmp_path / "worlds", world())
    assert [engine.keys() for engine in again.engines] == [engine.keys() for engine in env.engines]
    assert len(again.engines) == 2
    _, info = again.reset()
    assert info["graph_nodes"] > 1 and len(again.engines) == 2


def test_a_vector_environment_goes_on_from_its_file(tmp_path):
    def envs(number=2):
        return SyncVectorEnv([lambda: Corridor(limit=20)] * number)

    one = eigentrail.ShapedVec(envs(), gamma=1.0, reward="raw")
    _, info = one.reset(seed=0)
    for _ in range(100):
        _, _, _, _, info = one.step(info["advice"].argmax(axis=1))
    one.save(tmp_path / "worlds")
    other = eigentrail.ShapedVec.load(tmp_path / "worlds", envs())
    one.reset(seed=1)
    other.reset(seed=1)
    for actions in np.random.default_rng(0).integers(2, size=(60, 2)):
        said, heard = one.step(actions), other.step(actions)
        np.testing.assert_array_equal(said[1], heard[1])
        np.testing.assert_array_equal(said[4]["shaping"], heard[4]["shaping"])
    with pytest.raises(ValueError, match="worlds: saved with 2 environments, not 3"):
        eigentrail.ShapedVec.load(tmp_path / "worlds", envs(3))


def test_a_key_that_is_a_function_is_given_again(tmp_path):
    def key(env):
        return env.unwrapped.room

    env = eigentrail.Shaped(Corridor(), key=key)
    walked(env, 50)
    env.save(tmp_path / "worlds")
    with pytest.raises(ValueError, match="named by a function, which no file holds: give it as key"):
        eigentrail.Shaped.load(tmp_path / "worlds", Corridor())
    again = eigentrail.Shaped.load(tmp_path / "worlds", Corridor(), key=key)
    assert again.engine.keys() == env.engine.keys()


def test_files_that_are_damaged_or_of_something_else_are_refused(tmp_path):
    env = eigentrail.Shaped(Corridor())
    walked(env, 50)
    path = tmp_path / "worlds"
    env.save(path)
    good = path.read_bytes()
    path.write_bytes(good[:-40] + bytes([good[-40] ^ 1]) + good[-39:])
    with pytest.raises(ValueError, match="worlds: damaged: the checksum"):
        eigentrail.Shaped.load(path, Corridor())
    env.engine.save(path)
    with pytest.raises(ValueError, match="holds an object of kind ENGN, not WRLD"):
        eigentrail.Shaped.load(path, Corridor())
    path.write_bytes(good)
    with pytest.raises(ValueError, match="saved with 2 actions, not 4"):
        eigentrail.Shaped.load(path, gym.make("FrozenLake-v1"))


@pytest.mark.parametrize("key", ["obs", lambda env: env.unwrapped.room])
def test_copies_of_vector_environments_go_on_alike(key):
    envs = eigentrail.ShapedVec(SyncVectorEnv([lambda: Corridor(limit=20)] * 2), key=key, gamma=0.9)
    envs.reset(seed=0)
    actions = np.random.default_rng(0).integers(2, size=(120, 2)) * np.random.default_rng(1).integers(2, size=(120, 2))
    for some in actions[:60]:
        envs.step(some)
    other = copy.deepcopy(envs)
    for some in actions[60:]:
        said, heard = envs.step(some), other.step(some)
        np.testing.assert_array_equal(said[1], heard[1])
        np.testing.assert_array_equal(said[4]["node"], heard[4]["node"])
    assert envs.engine is not other.engine
