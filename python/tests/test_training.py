"""The built-in agent on Gymnasium environments."""

from __future__ import annotations

import eigentrail
import gymnasium as gym
import minigrid  # noqa: F401 (registers its worlds)
import numpy as np
import pytest
from conftest import Corridor
from minigrid.wrappers import ReseedWrapper


def test_it_finds_the_goal_and_the_best_way_there():
    result = eigentrail.train(Corridor(length=20), gamma=1.0, max_steps=600)
    assert result.steps == 600 and result.nodes == 20
    assert 19 <= result.first_goal_step <= 100
    assert (result.episodes["return"] == -result.episodes["length"]).all()
    assert result.episodes["length"][-5:].tolist() == [19] * 5
    assert result.episodes["end_step"][0] == result.first_goal_step
    assert [result.policy(room) for room in range(19)] == [0] * 19
    assert result.policy(99) is None


@pytest.mark.parametrize("name", ["CliffWalking-v1", "FrozenLake-v1"])
def test_its_policy_is_as_good_as_the_exact_one(name):
    arguments = {} if name.startswith("Cliff") else {"is_slippery": False}
    env = gym.make(name, **arguments)
    result = eigentrail.train(env, max_steps=5000, seed=1)
    state, _ = env.reset(seed=0)
    earned = 0.0
    for _ in range(30):
        state, reward, terminated, _, _ = env.step(result.policy(state))
        earned += reward
        if terminated:
            break
    assert earned == eigentrail.explore(env).solve(1.0).optimal_return


def test_a_key_and_a_door_are_no_hindrance():
    env = ReseedWrapper(gym.make("MiniGrid-DoorKey-5x5-v0"), seeds=(0,))
    result = eigentrail.train(env, key="minigrid", gamma=0.99, max_steps=6000)
    assert result.first_goal_step is not None
    assert result.episodes["return"][-5:].min() > 0.9


@pytest.mark.parametrize("name", ["MiniGrid-Empty-8x8-v0", "MiniGrid-FourRooms-v0", "MiniGrid-LavaGapS7-v0"])
def test_it_hurries_where_rewards_fall_with_the_time(name):
    env = ReseedWrapper(gym.make(name), seeds=(3,))
    result = eigentrail.train(env, key="minigrid", max_steps=12_000)
    last = result.episodes[-len(result.episodes) // 10 :]
    assert (last["return"] > 0).all()
    # What it has learnt is a shortest way: what the exact MDP earns with a discount that is nearly none, times cannot be told apart.
    gamma = 0.999
    mdp = eigentrail.explore(ReseedWrapper(gym.make(name), seeds=(3,)), key="minigrid")
    best = mdp.solve(gamma).optimal_return / mdp.reward[mdp.ends].max()
    shortest = 1 + np.log(best) / np.log(gamma)
    assert last["length"].min() <= shortest + 0.5
    assert np.median(last["length"]) <= 1.2 * shortest


def test_what_a_goal_of_minigrid_pays_is_without_the_clock():
    env = ReseedWrapper(gym.make("MiniGrid-Empty-5x5-v0"), seeds=(0,))
    key = eigentrail.keys.Namer("minigrid")
    env.reset()
    key.reset(env)
    rewards = []
    for action in [2, 2, 1, 2, 2]:
        _, reward, terminated, _, _ = env.step(action)
        rewards.append((reward, key.timeless(env, reward)))
    assert terminated and 0 < rewards[-1][0] < 1
    assert [timeless for _, timeless in rewards] == [0, 0, 0, 0, 1]


def test_equal_seeds_give_equal_results():
    first, second = (eigentrail.train(Corridor(), max_steps=500, seed=3) for _ in range(2))
    np.testing.assert_array_equal(first.episodes, second.episodes)


def test_a_goal_that_is_never_reached_is_none():
    result = eigentrail.train(Corridor(length=50, limit=20), max_steps=100)
    assert result.first_goal_step is None and len(result.episodes) == 5
    assert not result.episodes["terminated"].any()


def test_parameters_are_those_of_a_scenario():
    plain = eigentrail.train(Corridor(), max_steps=300, agent={"kind": "q-learning"}, shaping={"potential": "none"})
    assert (plain.episodes["shaped_return"] == plain.episodes["return"]).all()
    with pytest.raises(ValueError, match="unknown variant `q`"):
        eigentrail.train(Corridor(), agent={"kind": "q"})
    with pytest.raises(ValueError, match="agent.gamma = 2"):
        eigentrail.train(Corridor(), gamma=2.0)
