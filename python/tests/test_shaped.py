"""The wrapper of one environment."""

from __future__ import annotations

import copy
import json
import pickle
import sys
import types
import warnings

import eigentrail
import gymnasium as gym
import minigrid  # noqa: F401 (registers its worlds)
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env, data_equivalence
from gymnasium.wrappers import RecordEpisodeStatistics
from minigrid.wrappers import ReseedWrapper

MINIGRID = [
    "MiniGrid-Empty-8x8-v0",
    "MiniGrid-FourRooms-v0",
    "MiniGrid-DoorKey-5x5-v0",
    "MiniGrid-DoorKey-8x8-v0",
    "MiniGrid-MultiRoom-N4-S5-v0",
    "MiniGrid-MultiRoom-N6-v0",
    "MiniGrid-KeyCorridorS3R3-v0",
    "MiniGrid-LavaGapS7-v0",
    "MiniGrid-DistShift1-v0",
]
WORLDS = [("FrozenLake-v1", "obs"), ("Taxi-v4", "obs"), ("CliffWalking-v1", "obs")] + [(name, "minigrid") for name in MINIGRID]


def registered(name: str) -> str:
    """The newest version of a world that is there."""
    stem = name.rsplit("-v", 1)[0]
    versions = [spec for spec in gym.registry if spec.rsplit("-v", 1)[0] == stem]
    return max(versions, key=lambda spec: int(spec.rsplit("-v", 1)[1]))


# For agents that do nothing but follow advice.
FOLLOWED = {"exploration": {"potential_advice": 20.0}}


def rollout(env: gym.Env, steps: int, seed: int, advised: bool = False) -> list:
    env.action_space.seed(seed)
    said = [env.reset(seed=seed)]
    for _ in range(steps):
        action = int(said[-1][-1]["advice"].argmax()) if advised else env.action_space.sample()
        said.append(env.step(action))
        if said[-1][2] or said[-1][3]:
            said.append(env.reset())
    return said


@pytest.mark.parametrize(("name", "key"), WORLDS)
def test_gymnasium_has_nothing_to_find_fault_with(name, key):
    env = eigentrail.Shaped(gym.make(registered(name)), key=key, gamma=0.99)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        check_env(env, skip_render_check=True)


@pytest.mark.parametrize(("name", "key"), WORLDS)
def test_equal_seeds_give_equal_rollouts(name, key):
    def one():
        return eigentrail.Shaped(gym.make(registered(name)), key=key, gamma=0.99, seed=4)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        first, second = rollout(one(), 150, 11), rollout(one(), 150, 11)
    assert data_equivalence(first, second, exact=True)


@pytest.mark.parametrize(("name", "advised"), [("FrozenLake-v1", False), ("CliffWalking-v1", True), ("Taxi-v4", True)])
def test_shaping_telescopes_and_is_the_difference_of_the_returns(name, advised):
    gamma = 0.97
    env = eigentrail.Shaped(gym.make(registered(name)), gamma=gamma, **FOLLOWED)
    start, total, t, largest, ends = None, 0.0, 0, 0.0, 0
    for said in rollout(env, 3000, 0, advised):
        info = said[-1]
        if len(said) == 2:
            start, total, t = info["phi"], 0.0, 0
            assert info["shaping"] == info["extrinsic_reward"] == 0.0
            continue
        _, reward, terminated, truncated, _ = said
        assert reward == info["extrinsic_reward"] + info["shaping"]
        total += gamma**t * info["shaping"]
        t += 1
        largest = max(largest, abs(info["shaping"]))
        if terminated:
            assert info["phi"] == 0.0
        if terminated or truncated:
            ends += 1
            assert total == pytest.approx(gamma**t * info["phi"] - start, abs=1e-9 * (1 + largest * t))
    assert ends > 3 and largest > 0


def test_truncation_keeps_the_potential(corridor):
    env = eigentrail.Shaped(corridor(limit=30), gamma=1.0, **FOLLOWED)
    rollout(env, 300, 0, advised=True)
    _, info = env.reset()
    for _ in range(30):
        _, _, terminated, truncated, info = env.step(1)
    assert truncated and not terminated
    assert info["phi"] == env.engine.phi(info["node"]) < -5


def test_what_an_environment_does_wrong_leaves_the_graph_as_it_was(corridor):
    class Faulty(gym.Wrapper):
        fault = None

        def step(self, action):
            if self.fault == "raises":
                raise ZeroDivisionError("out of order")
            observation, reward, *rest = self.env.step(action)
            return observation, float("nan") if self.fault == "nan" else reward, *rest

    faulty = Faulty(corridor())
    env = eigentrail.Shaped(faulty, gamma=1.0, **FOLLOWED)
    rollout(env, 100, 0, advised=True)
    env.reset()
    env.step(0)

    def known():
        engine = env.engine
        return engine.num_nodes, engine.num_edges, engine.steps, engine.potential().tolist(), engine.eigenvalues().tolist()

    before = known()
    for fault, error, said in [
        ("raises", ZeroDivisionError, "out of order"),
        ("nan", ValueError, "the reward is NaN; rewards must be finite"),
    ]:
        faulty.fault = fault
        with pytest.raises(error, match=said):
            env.step(0)
        assert known() == before
    faulty.fault = None
    with pytest.raises(ValueError, match=r"action 2 of a world whose actions are 0\.\.2"):
        env.step(2)
    assert known() == before
    env.reset()
    rollout(env, 100, 1, advised=True)
    assert env.engine.steps == before[2] + 100 and env.engine.num_nodes == 9


def test_the_reward_that_step_returns_can_be_the_raw_one(corridor):
    one = eigentrail.Shaped(corridor(), gamma=1.0, reward="raw", **FOLLOWED)
    said = rollout(one, 200, 0, advised=True)
    assert {step[1] for step in said if len(step) == 5} == {-1.0}
    assert any(step[-1]["shaping"] for step in said)
    with pytest.raises(ValueError, match="reward = 'plain': must be one of 'shaped', 'raw'"):
        eigentrail.Shaped(corridor(), reward="plain")


def test_statistics_inside_are_of_raw_returns(corridor):
    env = eigentrail.Shaped(RecordEpisodeStatistics(corridor()), gamma=1.0, **FOLLOWED)
    checked = 0
    length = 0
    for said in rollout(env, 300, 0, advised=True):
        length = 0 if len(said) == 2 else length + 1
        if "episode" in said[-1] and len(said) == 5:
            assert said[-1]["episode"]["r"] == -length
            checked += 1
    assert checked >= 5


def test_a_monitor_is_put_inside_where_stable_baselines_is_in_use(corridor, monkeypatch):
    class Monitor(gym.Wrapper):
        pass

    module = types.ModuleType("stable_baselines3.common.monitor")
    module.Monitor = Monitor
    assert "stable_baselines3" not in sys.modules
    assert not isinstance(eigentrail.Shaped(corridor()).env, Monitor)
    for name in ("stable_baselines3", "stable_baselines3.common"):
        monkeypatch.setitem(sys.modules, name, types.ModuleType(name))
    monkeypatch.setitem(sys.modules, "stable_baselines3.common.monitor", module)
    assert isinstance(eigentrail.Shaped(corridor()).env, Monitor)
    assert not isinstance(eigentrail.Shaped(corridor(), monitor=False).env, Monitor)
    inside = RecordEpisodeStatistics(corridor())
    assert eigentrail.Shaped(inside).env is inside
    already = Monitor(corridor())
    assert eigentrail.Shaped(already).env is already


def test_the_info_of_the_environment_is_kept_and_not_written_to(corridor):
    inner = corridor()
    env = eigentrail.Shaped(inner, gamma=1.0)
    _, info = env.reset(options={"room": 3}, seed=1)
    assert info["age"] == 0 and info["graph_nodes"] == 1
    _, _, _, _, info = env.step(0)
    assert info["age"] == 1 and info["graph_nodes"] == 2 and info["advice"].shape == (2,)
    assert set(info) == {"age", "extrinsic_reward", "shaping", "advice", "phi", "node", "graph_nodes"}
    assert env.engine.keys() == [eigentrail.canonical(3), eigentrail.canonical(4)]


def test_a_spec_can_be_written_down_and_made_again():
    env = eigentrail.Shaped(gym.make("FrozenLake-v1"), key="obs", gamma=0.9, shaping={"potential": "hops"})
    text = env.spec.to_json()
    assert json.loads(text)["nondeterministic"] is True
    again = gym.make(gym.envs.registration.EnvSpec.from_json(text))
    assert isinstance(again, eigentrail.Shaped) and again.gamma == 0.9
    eigentrail.register_key("my board", lambda env: env.unwrapped.s)
    assert "my board" in eigentrail.Shaped(gym.make("FrozenLake-v1"), key="my board").spec.to_json()


def test_keys_of_every_form_name_states(corridor):
    class Counted:
        resets = 0

        def reset(self, env):
            self.resets += 1

        def __call__(self, env, observation):
            return {"room": observation, "resets": self.resets}

    by_env = eigentrail.Shaped(corridor(), key=lambda env: ("room", env.unwrapped.room))
    by_both = eigentrail.Shaped(corridor(), key=lambda env, observation: observation)
    by_class = eigentrail.Shaped(corridor(), key=Counted)
    for env in (by_env, by_both, by_class):
        env.reset()
        env.step(0)
    assert by_env.engine.keys() == [eigentrail.canonical(("room", room)) for room in (0, 1)]
    assert by_both.engine.keys() == [eigentrail.canonical(room) for room in (0, 1)]
    assert by_class.engine.keys()[0] == eigentrail.canonical({"room": 0, "resets": 1})
    with pytest.raises(ValueError, match='no key is called "observation": choose one of "'):
        eigentrail.Shaped(corridor(), key="observation")
    with pytest.raises(TypeError, match="a key is a name or a function of the environment, not int"):
        eigentrail.Shaped(corridor(), key=7)
    with pytest.raises(TypeError, match="name states of MiniGrid worlds"):
        eigentrail.Shaped(corridor(), key="minigrid").reset()


def test_only_finitely_many_actions_are_taken():
    env = gym.make("MountainCarContinuous-v0")
    with pytest.raises(TypeError, match="eigentrail needs finitely many actions"):
        eigentrail.Shaped(env)


def test_actions_may_begin_at_another_number_than_zero(corridor):
    class From(gym.ActionWrapper):
        def __init__(self, env):
            super().__init__(env)
            self.action_space = gym.spaces.Discrete(2, start=5)

        def action(self, action):
            return action - 5

    env = eigentrail.Shaped(From(corridor()), gamma=1.0)
    env.reset()
    for _ in range(8):
        _, _, terminated, _, _ = env.step(np.int64(5))
    assert terminated and set(env.engine.graph().action) == {0}


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
@pytest.mark.parametrize(("name", "key"), [("FrozenLake-v1", "obs"), ("MiniGrid-DoorKey-5x5-v0", "minigrid")])
def test_copies_go_on_alike(copied, name, key):
    env = eigentrail.Shaped(ReseedWrapper(gym.make(name).unwrapped, seeds=(3,)), key=key, gamma=0.99)
    rollout(env, 100, 0)
    env.reset(seed=1)
    other = copied(env)
    actions = np.random.default_rng(0).integers(env.action_space.n, size=60)
    for action in actions:
        one, two = env.step(int(action)), other.step(int(action))
        assert data_equivalence(one[1:], two[1:], exact=True)
        if one[2] or one[3]:
            break


def test_each_layout_has_a_graph_of_its_own():
    env = eigentrail.Shaped(ReseedWrapper(gym.make("MiniGrid-FourRooms-v0"), seeds=(0, 1)), key="minigrid", gamma=0.99)
    sizes: dict[int, int] = {}
    env.action_space.seed(0)
    for episode in range(6):
        _, info = env.reset()
        before = sizes.get(episode % 2, 0)
        assert info["graph_nodes"] >= max(before, 1) and (before == 0) == (info["graph_nodes"] == 1)
        for _ in range(40):
            _, _, _, _, info = env.step(env.action_space.sample())
        sizes[episode % 2] = info["graph_nodes"]
    assert len(env.engines) == 2 and env.engine is env.engines[-1]
    assert {engine.num_nodes for engine in env.engines} == set(sizes.values())


def test_layouts_that_are_not_kept_in_mind_are_forgotten():
    env = eigentrail.Shaped(gym.make("MiniGrid-MultiRoom-N2-S4-v0"), key="minigrid", max_layouts=3)
    for seed in range(8):
        env.reset(seed=seed)
    assert len(env.engines) == 3


def test_layouts_that_never_repeat_are_warned_of():
    env = eigentrail.Shaped(gym.make("MiniGrid-FourRooms-v0"), key="minigrid")
    with pytest.warns(UserWarning, match="each of 20 episodes had a layout that was new"):
        for seed in range(20):
            env.reset(seed=seed)


def test_states_that_never_repeat_are_warned_of(corridor):
    env = eigentrail.Shaped(corridor(limit=10**6), key=lambda env: (env.unwrapped.room, env.unwrapped.age))
    with pytest.warns(UserWarning, match="1000 of 1000 steps led to a state that was never seen"):
        env.reset()
        for _ in range(1000):
            env.step(1)


def test_a_key_that_confuses_states_is_warned_of(corridor):
    class Locked(corridor):
        """The door behind room 1 is locked until the lever in room 0 was pulled, by going back there."""

        def reset(self, **kwargs):
            self.is_open = False
            return super().reset(**kwargs)

        def step(self, action):
            self.is_open |= self.room == 0 and action == 1
            if self.room == 1 and action == 0 and not self.is_open:
                self.room = 0  # and pushed back
            return super().step(action)

    def wandered(key):
        env = eigentrail.Shaped(Locked(length=4, limit=8), key=key)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            rollout(env, 20_000, 0)
        return [str(w.message) for w in caught if "behave differently" in str(w.message)]

    assert len(wandered("obs")) == 1
    assert wandered(lambda env: (env.unwrapped.room, env.unwrapped.is_open)) == []


def test_a_slippery_world_is_not_taken_for_a_bad_key():
    env = eigentrail.Shaped(gym.make("FrozenLake-v1"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rollout(env, 20_000, 0)
