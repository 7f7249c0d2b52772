"""Stable-Baselines3, against the wrapper of one environment."""

from __future__ import annotations

import copy
import pickle
import warnings

import eigentrail
import gymnasium as gym
import minigrid  # noqa: F401 (registers its worlds)
import numpy as np
import pytest
import torch
from conftest import Corridor
from gymnasium.utils.env_checker import check_env as check_gymnasium
from minigrid.wrappers import ImgObsWrapper, ReseedWrapper
from stable_baselines3 import A2C, DQN, PPO
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.logger import Logger, configure
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv, VecMonitor

from eigentrail.sb3 import AdvisedPolicy, GraphCallback, ShapedVecEnv

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
RNG = np.random.default_rng(3)
ACTIONS = [int(action) for action in RNG.random(900) < 0.25]  # on, with a step back now and then


def newest(stem: str) -> str:
    versions = [spec for spec in gym.registry if spec.rsplit("-v", 1)[0] == stem]
    return max(versions, key=lambda spec: int(spec.rsplit("-v", 1)[1]))


def fixed(name: str) -> gym.Env:
    return ImgObsWrapper(ReseedWrapper(gym.make(name), seeds=(0,)))


class SameLayout(gym.Wrapper, gym.utils.RecordConstructorArgs):
    """Holds the layout fast, and the generator is seeded all the same: ReseedWrapper, which drops seeds, is found fault with."""

    def __init__(self, env):
        gym.utils.RecordConstructorArgs.__init__(self)
        super().__init__(env)

    def reset(self, *, seed=None, options=None):
        result = self.env.reset(seed=0, options=options)
        if seed is not None:
            self.unwrapped.np_random = np.random.default_rng(seed)
        return result


@pytest.mark.parametrize("stem", ["FrozenLake", "Taxi", "CliffWalking"])
def test_nothing_is_wrong_with_toy_worlds(stem):
    check_env(eigentrail.Shaped(gym.make(newest(stem)), key="obs", gamma=0.99))


@pytest.mark.parametrize("name", MINIGRID)
def test_nothing_is_wrong_with_minigrid(name):
    env = eigentrail.Shaped(fixed(name), key="minigrid", gamma=0.99)
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*(image|observation space).*")
        check_env(env)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        env = eigentrail.Shaped(SameLayout(gym.make(name)), key="minigrid", gamma=0.99, monitor=False)
        check_gymnasium(env, skip_render_check=True)


@pytest.mark.parametrize("name", MINIGRID)
def test_equal_seeds_give_equal_rollouts(name):
    def rollout() -> list:
        venv = DummyVecEnv([lambda: fixed(name)] * 2)
        venv = ShapedVecEnv(venv, key="minigrid", gamma=0.99, seed=4)
        venv.seed(1)
        told = [venv.reset().tolist(), venv.advice().tolist()]
        rng = np.random.default_rng(5)
        for _ in range(60):
            observations, rewards, dones, infos = venv.step(rng.integers(venv.action_space.n, size=2))
            told += [observations.tolist(), rewards.tolist(), dones.tolist(), [info["advice"].tolist() for info in infos]]
        return told

    assert rollout() == rollout()


def test_a_monitor_is_inside_by_default(corridor):
    assert isinstance(eigentrail.Shaped(corridor()).env, Monitor)
    assert not isinstance(eigentrail.Shaped(corridor(), monitor=False).env, Monitor)
    here = ShapedVecEnv(DummyVecEnv([corridor] * 2))
    assert here.env_is_wrapped(Monitor) == [True, True] and isinstance(here.venv, DummyVecEnv)
    assert isinstance(ShapedVecEnv(VecMonitor(DummyVecEnv([corridor]))).venv.venv, DummyVecEnv)
    there = SubprocVecEnv([corridor], start_method="fork")
    assert isinstance(ShapedVecEnv(there).venv, VecMonitor)
    there.close()


@pytest.mark.parametrize("key", ["obs", lambda env: env.unwrapped.room])
def test_one_environment_is_the_wrapper_of_one_environment(key):
    alone = eigentrail.Shaped(Corridor(limit=12), key=key, gamma=0.95, monitor=False)
    venv = ShapedVecEnv(DummyVecEnv([lambda: Corridor(limit=12)]), key=key, gamma=0.95)
    alone.reset(seed=0)
    venv.reset()
    ends = cuts = 0
    for action in ACTIONS:
        observation, reward, terminated, truncated, expected = alone.step(action)
        observations, rewards, dones, infos = venv.step(np.array([action]))
        info = infos[0]
        assert rewards[0] == np.float32(reward) and info["shaping"] == expected["shaping"]
        assert dones[0] == (terminated or truncated)
        if dones[0]:
            assert info["terminal_observation"] == observation
            assert info["TimeLimit.truncated"] == truncated
            ends, cuts = ends + terminated, cuts + truncated
            observation, expected = alone.reset()
        assert observations[0] == observation and info["node"] == expected["node"] and info["phi"] == expected["phi"]
        np.testing.assert_array_equal(info["advice"], expected["advice"])
        np.testing.assert_array_equal(venv.advice()[0], expected["advice"])
    assert ends > 5 and cuts > 5


def test_walkers_share_one_world_and_shaping_telescopes_for_each():
    gamma, number = 0.9, 3
    venv = ShapedVecEnv(
        DummyVecEnv([lambda: Corridor(limit=25)] * number), gamma=gamma, exploration={"potential_advice": 20.0}
    )
    venv.reset()
    start = np.array([info["phi"] for info in venv.reset_infos])
    total, age, ends = np.zeros(number), np.zeros(number), 0
    for _ in range(400):
        _, _, dones, infos = venv.step(venv.advice().argmax(axis=1))
        for i, info in enumerate(infos):
            total[i] += gamma ** age[i] * info["shaping"]
            age[i] += 1
            if dones[i]:
                if not info["TimeLimit.truncated"]:
                    ends += 1
                    assert total[i] == pytest.approx(-start[i], abs=1e-9)
                start[i], total[i], age[i] = info["phi"], 0.0, 0
    assert ends > 20
    assert len({id(engine) for engine in venv.engines}) == 1 and venv.engine.num_nodes == 9


def test_environments_in_other_processes_are_named_by_their_observations():
    here = ShapedVecEnv(DummyVecEnv([lambda: Corridor(limit=20)] * 2), gamma=1.0)
    there = ShapedVecEnv(SubprocVecEnv([lambda: Corridor(limit=20)] * 2, start_method="fork"), gamma=1.0)
    here.reset()
    there.reset()
    for actions in RNG.integers(2, size=(100, 2)) * (RNG.random((100, 2)) < 0.4):
        said, heard = here.step(actions), there.step(actions)
        np.testing.assert_array_equal(said[1], heard[1])
        assert [info["node"] for info in said[3]] == [info["node"] for info in heard[3]]
    with pytest.raises(TypeError, match="the environments of SubprocVecEnv, which are elsewhere"):
        ShapedVecEnv(there.venv.unwrapped, key=lambda env: env.unwrapped.room)
    there.close()


def test_observations_of_several_parts_and_real_numbers_are_named_alike_at_ends():
    class Parts(Corridor):
        def __init__(self) -> None:
            super().__init__(length=5)
            self.observation_space = gym.spaces.Dict(
                room=gym.spaces.Discrete(5), place=gym.spaces.Box(0, 5, (1,), np.float32)
            )

        def told(self, result):
            place = np.array([self.room], dtype=np.float64)  # not the type of the space
            return ({"room": self.room, "place": place}, *result[1:])

        def reset(self, **arguments):
            return self.told(super().reset(**arguments))

        def step(self, action):
            return self.told(super().step(action))

    venv = ShapedVecEnv(DummyVecEnv([Parts] * 2), gamma=1.0)
    venv.reset()
    for _ in range(40):
        venv.step(np.zeros(2, dtype=np.int64))
    assert venv.engine.num_nodes == 5


@pytest.mark.parametrize("advice", [False, True])
def test_the_curve_is_of_raw_returns(corridor, advice):
    venv = ShapedVecEnv(make_vec_env(corridor, n_envs=2), gamma=0.99, advice=advice)
    policy = AdvisedPolicy if advice else "MlpPolicy"
    model = PPO(policy, venv, gamma=0.99, n_steps=64, batch_size=64, device="cpu", seed=0)
    model.learn(2000)
    lengths = [episode["l"] for episode in model.ep_info_buffer]
    assert len(lengths) > 10 and [episode["r"] for episode in model.ep_info_buffer] == [-length for length in lengths]


def test_a_single_wrapped_environment_is_logged_raw_as_well(corridor):
    model = PPO("MlpPolicy", eigentrail.Shaped(corridor(), gamma=0.99), n_steps=64, batch_size=64, device="cpu", seed=0)
    model.learn(1000)
    assert model.ep_info_buffer and all(episode["r"] == -episode["l"] for episode in model.ep_info_buffer)


def test_an_advised_policy_draws_by_logits_and_advice():
    venv = ShapedVecEnv(make_vec_env(Corridor, n_envs=2), gamma=0.99, advice=True)
    model = PPO(AdvisedPolicy, venv, device="cpu", seed=0)
    observation = venv.reset()
    assert observation["advice"].dtype == np.float32 and set(observation) == {"observation", "advice"}
    tensors, _ = model.policy.obs_to_tensor(observation)
    with torch.no_grad():
        plain = model.policy.get_distribution({**tensors, "advice": torch.zeros(2, 2)}).distribution.logits
        bent = model.policy.get_distribution({**tensors, "advice": torch.tensor([[0.0, 3.0]] * 2)}).distribution
        values = [model.policy.predict_values({**tensors, "advice": torch.full((2, 2), a)}) for a in (0.0, 9.0)]
    expected = torch.log_softmax(plain + torch.tensor([0.0, 3.0]), dim=1)
    assert torch.allclose(bent.logits, expected, atol=1e-5)
    assert torch.equal(*values)
    # The ratio of PPO is of the probabilities by which actions were drawn.
    actions, _, chances = model.policy(tensors)
    _, again, _ = model.policy.evaluate_actions(tensors, actions)
    assert torch.allclose(chances, again)
    with pytest.raises(ValueError, match='no entry "advice"'):
        PPO(AdvisedPolicy, make_vec_env("FrozenLake-v1"), device="cpu")


def test_advice_finds_a_goal_that_chance_does_not():
    def first_goal(advice: bool) -> bool:
        venv = ShapedVecEnv(make_vec_env(lambda: Corridor(40, 60), n_envs=2), gamma=0.99, advice=advice)
        policy = AdvisedPolicy if advice else "MlpPolicy"
        PPO(policy, venv, gamma=0.99, n_steps=64, batch_size=64, device="cpu", seed=0).learn(2000)
        return bool(venv.engine.goals())

    assert first_goal(True) and not first_goal(False)


def test_an_advised_policy_bootstraps_where_episodes_are_cut_off():
    venv = ShapedVecEnv(make_vec_env(lambda: Corridor(9, 5), n_envs=2), gamma=0.99, advice=True)
    A2C(AdvisedPolicy, venv, gamma=0.99, device="cpu", seed=0).learn(200)
    venv.reset()
    for _ in range(5):
        _, _, dones, infos = venv.step(np.ones(2, dtype=np.int64))
    assert dones.all() and infos[0]["TimeLimit.truncated"]
    assert set(infos[0]["terminal_observation"]) == {"observation", "advice"}


def recorded(model, callback, steps: int, folder) -> dict[str, float]:
    seen: dict[str, float] = {}

    class Kept(Logger):
        def record(self, key, value, exclude=None):
            seen[key] = value
            super().record(key, value, exclude)

    model.set_logger(Kept(str(folder), configure(str(folder), ["csv"]).output_formats))
    model.learn(steps, callback=callback)
    return seen


@pytest.mark.parametrize("kind", [PPO, DQN])
def test_the_graph_is_in_the_logger(kind, corridor, tmp_path):
    if kind is PPO:
        env = ShapedVecEnv(make_vec_env(corridor, n_envs=2), gamma=0.99)
        model = PPO("MlpPolicy", env, gamma=0.99, n_steps=64, batch_size=64, device="cpu", seed=0)
    else:
        env = gym.wrappers.TransformReward(eigentrail.Shaped(corridor(), gamma=0.99), lambda reward: reward)
        model = DQN("MlpPolicy", env, gamma=0.99, device="cpu", seed=0, learning_starts=10)
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        seen = recorded(model, GraphCallback(every=100), 1500, tmp_path)
    assert seen["graph/nodes"] == 9 and seen["graph/edges"] == 8 and seen["graph/layouts"] == 1
    assert seen["graph/goals"] == 1 and seen["phi/min"] < 0 and seen["phi/max"] <= 0
    assert seen["pvf/eigenvalue_0"] == pytest.approx(0, abs=1e-9) and "pvf/eigenvalue_1" in seen
    assert seen["phi/raw_reward"] == -1.0


def test_a_model_with_another_gamma_is_warned_of(corridor):
    model = PPO("MlpPolicy", ShapedVecEnv(make_vec_env(corridor), gamma=0.9), n_steps=8, batch_size=8, device="cpu")
    with pytest.warns(UserWarning, match=r"the model's gamma is 0.99 and that of the shaping 0.9"):
        model.learn(8, callback=GraphCallback())


def test_the_callback_needs_a_wrapper(corridor):
    model = PPO("MlpPolicy", make_vec_env(corridor), n_steps=8, batch_size=8, device="cpu")
    with pytest.raises(ValueError, match="GraphCallback found no eigentrail around the environment"):
        model.learn(8, callback=GraphCallback())


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda venv: pickle.loads(pickle.dumps(venv))])
@pytest.mark.parametrize("key", ["obs", "minigrid"])
def test_copies_go_on_alike(copied, key):
    world = Corridor if key == "obs" else fixed
    arguments = {} if key == "obs" else {"name": "MiniGrid-DoorKey-5x5-v0"}
    envs = make_vec_env(world, n_envs=2, env_kwargs=arguments)
    venv = ShapedVecEnv(envs, key=key, gamma=0.99)
    venv.reset()
    actions = RNG.integers(venv.action_space.n, size=(200, 2))
    for some in actions[:100]:
        venv.step(some)
    other = copied(venv)
    for some in actions[100:]:
        one, two = venv.step(some), other.step(some)
        np.testing.assert_array_equal(one[1], two[1])
        assert [info["node"] for info in one[3]] == [info["node"] for info in two[3]]


def test_what_was_found_out_is_saved_and_loaded(corridor, tmp_path):
    venv = ShapedVecEnv(make_vec_env(corridor, n_envs=2), gamma=0.9, advice=True)
    venv.reset()
    for _ in range(50):
        venv.step(venv.advice().argmax(axis=1))
    venv.save(tmp_path / "worlds")
    again = ShapedVecEnv.load(tmp_path / "worlds", make_vec_env(corridor, n_envs=2))
    assert again.gamma == 0.9 and again.engine.goals() == venv.engine.goals() != []
    np.testing.assert_array_equal(again.engine.potential(), venv.engine.potential())
    assert set(again.reset()) == {"observation", "advice"}
    with pytest.raises(ValueError, match="saved with 2 environments, not 3"):
        ShapedVecEnv.load(tmp_path / "worlds", make_vec_env(corridor, n_envs=3))
