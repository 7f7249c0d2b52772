"""TorchRL, against the wrapper of one environment."""

from __future__ import annotations

import eigentrail
import gymnasium as gym
import minigrid  # noqa: F401 (registers its worlds)
import numpy as np
import pytest
import torch
from conftest import Corridor
from minigrid.wrappers import ImgObsWrapper, ReseedWrapper
from torchrl.envs import GymWrapper, ParallelEnv, SerialEnv, TransformedEnv
from torchrl.envs.utils import check_env_specs

from eigentrail.torchrl import Shaping

ACTIONS = [int(action) for action in np.random.default_rng(3).random(600) < 0.25]


def corridor(one_hot: bool = False) -> GymWrapper:
    return GymWrapper(Corridor(limit=12), categorical_action_encoding=not one_hot)


def doors() -> gym.Env:
    return ImgObsWrapper(ReseedWrapper(gym.make("MiniGrid-DoorKey-5x5-v0"), seeds=(3,)))


def held_against(alone: gym.Env, env: TransformedEnv, actions: list[int], one_hot: bool) -> int:
    """Steps both: the number of episodes that came to an end."""
    told, (_, expected) = env.reset(), alone.reset(seed=0)
    ends = 0
    for action in actions:
        assert told["phi"].item() == np.float32(expected["phi"])
        np.testing.assert_array_equal(told["advice"].numpy(), expected["advice"].astype(np.float32))
        chosen = torch.tensor(action)
        told["action"] = torch.nn.functional.one_hot(chosen, env.action_spec.space.n) if one_hot else chosen
        told, after = env.step_and_maybe_reset(told)
        _, reward, terminated, truncated, expected = alone.step(action)
        assert told["next", "reward"].item() == np.float32(reward)
        assert told["next", "shaping"].item() == np.float32(expected["shaping"])
        assert told["next", "extrinsic_reward"].item() == np.float32(expected["extrinsic_reward"])
        assert told["next", "phi"].item() == np.float32(expected["phi"])
        assert told["next", "done"].item() == (terminated or truncated)
        if terminated or truncated:
            ends += 1
            _, expected = alone.reset()
        told = after
    return ends


@pytest.mark.parametrize("one_hot", [False, True])
@pytest.mark.parametrize("key", ["obs", lambda env: env.unwrapped.room])
def test_rewards_are_those_of_the_wrapper(one_hot, key):
    alone = eigentrail.Shaped(Corridor(limit=12), key=key, gamma=0.95)
    env = TransformedEnv(corridor(one_hot), Shaping(key=key, gamma=0.95))
    assert held_against(alone, env, ACTIONS, one_hot) > 20
    assert env.transform.engine.num_nodes == alone.engine.num_nodes
    np.testing.assert_array_equal(env.transform.engine.potential(), alone.engine.potential())


def test_keys_of_minigrid_look_inside():
    alone = eigentrail.Shaped(doors(), key="minigrid", gamma=0.99)
    env = TransformedEnv(GymWrapper(doors(), categorical_action_encoding=True), Shaping(key="minigrid", gamma=0.99))
    actions = np.random.default_rng(1).integers(7, size=400).tolist()
    assert held_against(alone, env, actions, False) >= 1
    assert env.transform.engine.keys() == alone.engine.keys()


@pytest.mark.parametrize("key", ["obs", lambda env: env.unwrapped.room])
def test_several_environments_are_those_of_gymnasium(key):
    envs = gym.vector.SyncVectorEnv([lambda: Corridor(limit=12)] * 3, autoreset_mode="SameStep")
    envs = eigentrail.ShapedVec(envs, key=key, gamma=0.95)
    env = TransformedEnv(SerialEnv(3, corridor), Shaping(key=key, gamma=0.95))
    envs.reset(seed=0)
    told = env.reset()
    ends = 0
    for step in range(300):
        actions = np.array([ACTIONS[step], ACTIONS[step + 100], ACTIONS[step + 200]])
        told["action"] = torch.from_numpy(actions)
        told, after = env.step_and_maybe_reset(told)
        _, rewards, terminated, truncated, info = envs.step(actions)
        np.testing.assert_array_equal(told["next", "reward"].squeeze(-1).numpy(), rewards.astype(np.float32))
        np.testing.assert_array_equal(after["advice"].numpy(), info["advice"].astype(np.float32))
        ends += int((terminated | truncated).sum())
        told = after
    assert ends > 30 and env.transform.engine.num_walkers == 3


def test_environments_in_other_processes_are_named_by_their_observations():
    env = TransformedEnv(ParallelEnv(2, corridor, mp_start_method="fork"), Shaping(gamma=0.95))
    rollout = env.rollout(60, break_when_any_done=False)
    assert rollout["next", "advice"].shape == (2, 60, 2) and env.transform.engine.steps == 120
    inside = TransformedEnv(ParallelEnv(2, corridor, mp_start_method="fork"), Shaping(key=lambda env: env.unwrapped.room))
    with pytest.raises(TypeError, match="cannot: use"):
        inside.reset()
    env.close()


def test_torchrl_finds_no_fault_with_the_specs():
    check_env_specs(TransformedEnv(corridor(), Shaping(gamma=0.9)))
    check_env_specs(TransformedEnv(SerialEnv(2, corridor), Shaping(gamma=0.9)))


def test_the_reward_can_be_the_raw_one():
    env = TransformedEnv(GymWrapper(Corridor(), categorical_action_encoding=True), Shaping(gamma=0.9, reward="raw"))
    torch.manual_seed(0)
    rollout = env.rollout(600, break_when_any_done=False)
    assert set(rollout["next", "reward"].flatten().tolist()) == {-1.0}
    assert rollout["next", "shaping"].abs().max() > 0


def test_what_cannot_be_is_said():
    with pytest.raises(ValueError, match="reward = 'plain'"):
        Shaping(reward="plain")
    with pytest.raises(RuntimeError, match="no part of an environment yet"):
        Shaping().engine  # noqa: B018
    with pytest.raises(TypeError, match="finitely many actions"):
        TransformedEnv(GymWrapper(gym.make("Pendulum-v1")), Shaping()).reset()
    with pytest.raises(KeyError, match='no entry "pixels"'):
        TransformedEnv(corridor(), Shaping(observation="pixels")).reset()
