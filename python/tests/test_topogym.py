"""The key of TopoGym, against what its worlds do. Runs where TopoGym is installed."""

from __future__ import annotations

import gymnasium as gym
import numpy as np
import pytest
from eigentrail.keys import Namer

pytest.importorskip("topogym")

# Worlds in which nothing is left to chance but the first heading.
CERTAIN = ["Dilution-50", "GiveUp2-50", "IceShip", "DontFall", "SearchRescue", "SpaceWarp", "TopKlein-50", "TopRP2-50"]


def make(name: str):
    env = gym.make(f"TopoGym/{name}-v0", seed=1000, disable_env_checker=True)
    env.unwrapped._obs = lambda: None  # the key does not look at views, which take most of the time
    return env


def walk(env: gym.Env, steps: int, forward: float = 0.7):
    """(Name, action, name that followed, reward, ended) of a walk that mostly goes forward."""
    rng = np.random.default_rng(0)
    namer = Namer("topogym")
    observation, _ = env.reset(seed=0)
    namer.reset(env)
    here = namer(env, observation)
    for _ in range(steps):
        action = 2 if rng.random() < forward else int(rng.integers(2))
        observation, reward, terminated, truncated, _ = env.step(action)
        there = namer(env, observation, terminated)
        yield here, action, there, reward, terminated
        here = there
        if terminated or truncated:
            observation, _ = env.reset()
            namer.reset(env)
            here = namer(env, observation)


@pytest.mark.parametrize("name", CERTAIN)
def test_what_follows_a_name_is_certain(name):
    known: dict[tuple[bytes, int], tuple[bytes, float, bool]] = {}
    ends, others = set(), set()
    for here, action, *what in walk(make(name), 4000):
        assert known.setdefault((here, action), tuple(what)) == tuple(what), "one name, two states"
        others.add(here)
        if what[2]:
            ends.add(what[0])
    assert len(others) > 300
    assert not ends & others, "where one episode ended another one went on"


def test_a_boat_that_hits_the_ice_is_not_where_it_was():
    ended = [(here, there) for here, _, there, _, terminated in walk(make("IceShip"), 4000) if terminated]
    assert len(ended) > 20
    assert all(here != there for here, there in ended)


def test_seasons_are_different_worlds():
    """Only the waves of a season come at a time that no name tells; all else is certain."""
    env = make("EnvironmentalIceShip")
    known: dict[tuple[bytes, int], set[object]] = {}
    for here, action, *what in walk(env, 8000, forward=0.5):
        if env.unwrapped._steps not in (20, 40):
            known.setdefault((here, action), set()).add(tuple(what))
    assert len(known) > 1000
    assert all(len(whats) == 1 for whats in known.values())


def test_other_worlds_are_refused():
    env = gym.make("FrozenLake-v1")
    env.reset(seed=0)
    with pytest.raises(TypeError, match="TopoGym"):
        Namer("topogym").reset(env)
