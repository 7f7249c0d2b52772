"""A vector environment of Stable-Baselines3 with shaped rewards."""

from __future__ import annotations

import inspect
from typing import Any

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import DummyVecEnv, VecEnv, VecEnvWrapper, VecMonitor, is_vecenv_wrapped

from ..engine import Engine, Floats
from ..keys import KeyLike
from ..saving import Saved
from ..walkers import Walkers, names
from ..worlds import require_choice, require_discrete


class ShapedVecEnv(Saved, VecEnvWrapper):
    """A vector environment with shaped rewards. What one of its environments finds out, all of them know.

    Parameters are those of :class:`eigentrail.Shaped`, and each environment's ``info`` has the same names. In the step
    that ends an episode, ``shaping`` is that of this step; ``node``, ``phi`` and ``advice`` are of the state in which the
    next one begins. ``reset_infos`` has them after ``reset``.

    - ``key``: one other than ``"obs"`` has to look into the environments, which those of a ``DummyVecEnv`` allow.
    - ``advice``: give it to the policy, as the entry ``"advice"`` of observations that are dictionaries; what was
      observed before is the entry ``"observation"``, unless it was a dictionary already. See :class:`AdvisedPolicy`.
    - ``monitor``: put a ``Monitor`` into each environment, or a ``VecMonitor`` around them if they are elsewhere, so that ``rollout/ep_rew_mean`` is of raw returns; ``None`` does so unless
      there is a monitor inside already. A monitor outside would be of what ``step`` returns.

    Where an episode was cut off (``TimeLimit.truncated``) its last state keeps its φ, and the learner goes on from
    ``terminal_observation`` as always.
    """

    def __init__(
        self,
        venv: VecEnv,
        key: KeyLike = "obs",
        gamma: float = 0.99,
        *,
        reward: str = "shaped",
        advice: bool = False,
        monitor: bool | None = None,
        seed: int = 0,
        max_layouts: int = 64,
        **params: dict[str, Any],
    ) -> None:
        require_choice("reward", reward, ("shaped", "raw"))
        actions = require_discrete(venv.action_space)
        self._settings = {
            "key": key,
            "gamma": gamma,
            "reward": reward,
            "advice": advice,
            "monitor": monitor,
            "seed": seed,
            "max_layouts": max_layouts,
            **params,
        }
        if monitor or (monitor is None and not _is_monitored(venv)):
            venv = _monitored(venv)
        super().__init__(venv)
        self.gamma = gamma
        self._returns_shaped = reward == "shaped"
        self._tells_advice = advice
        self._walkers = Walkers(venv.num_envs, actions, gamma, seed, max_layouts, params)
        self._worlds = self._walkers.worlds
        self._names = names(venv.unwrapped, key, "DummyVecEnv")
        self._actions = np.zeros(venv.num_envs, dtype=np.int64)
        if advice:
            self.observation_space = _with_advice_space(venv.observation_space, actions[0])

    def __getstate__(self) -> dict[str, Any]:
        # The list of attributes that every wrapper keeps cannot be written down.
        return {name: value for name, value in self.__dict__.items() if name != "class_attributes"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.class_attributes = dict(inspect.getmembers(type(self)))

    @property
    def engine(self) -> Engine:
        """The engine of the layout in which an episode was begun last; of worlds with one layout, the only one."""
        return self._worlds.first

    @property
    def engines(self) -> list[Engine]:
        """Of each environment, the engine of its layout."""
        return list(self._walkers.engines)

    def advice(self) -> Floats:
        """Environments × actions: advice for where each of them is."""
        return self._walkers.advice()

    def reset(self) -> Any:
        """Begins an episode in every environment."""
        observations = self.venv.reset()
        self._see(observations, {})
        nodes = np.array([self._begin(i) for i in range(self.num_envs)])
        told = self._told(nodes, np.zeros(self.num_envs), np.zeros(self.num_envs))
        before = getattr(self.venv, "reset_infos", None) or [{}] * self.num_envs
        self.reset_infos = [{**info, **more} for info, more in zip(before, told, strict=True)]
        return self._observed(observations)

    def step_async(self, actions: np.ndarray) -> None:
        """Sends the actions on their way."""
        self._actions = np.asarray(actions).reshape(self.num_envs)
        self.venv.step_async(actions)

    def step_wait(self) -> Any:
        """Takes what came of them into the graph."""
        observations, rewards, dones, infos = self.venv.step_wait()
        final = {int(i): infos[i]["terminal_observation"] for i in np.flatnonzero(dones)}
        self._see(observations, final)
        raw = np.asarray(rewards, dtype=np.float64)
        shaping, bonus = np.zeros(self.num_envs), np.zeros(self.num_envs)
        nodes = np.zeros(self.num_envs, dtype=np.int64)
        last_advice: dict[int, Floats] = {}
        for i in range(self.num_envs):
            cut_off = bool(dones[i]) and bool(infos[i].get("TimeLimit.truncated", False))
            over = bool(dones[i]) and not cut_off
            seen = self._walkers.observe(i, self._actions[i], self._names.reached(i), raw[i], over, cut_off)
            shaping[i], bonus[i], nodes[i] = seen.shaping, seen.bonus, seen.node
            if dones[i]:
                last_advice[i] = self._walkers.engines[i].advice(i)
                nodes[i] = self._begin(i)
        infos = [{**info, **more} for info, more in zip(infos, self._told(nodes, raw, shaping), strict=True)]
        if self._tells_advice:
            for i, advice in last_advice.items():
                infos[i]["terminal_observation"] = _with_advice(final[i], advice)
        if self._returns_shaped:
            rewards = (raw + shaping + bonus).astype(np.float32)
        return self._observed(observations), rewards, dones, infos

    def _begin(self, i: int) -> int:
        return self._walkers.begin(i, *self._names.begun(i))

    def _see(self, observations: Any, final: dict[int, Any]) -> None:
        if self._names.needs_observations:
            space = self.venv.observation_space
            present = [_one(space, _at(observations, i)) for i in range(self.num_envs)]
            self._names.see(present, {i: _one(space, last) for i, last in final.items()})

    def _observed(self, observations: Any) -> Any:
        return _with_advice(observations, self.advice()) if self._tells_advice else observations

    def _told(self, nodes: np.ndarray, raw: np.ndarray, shaping: np.ndarray) -> list[dict[str, Any]]:
        columns = {
            "extrinsic_reward": raw.tolist(),
            "shaping": shaping.tolist(),
            "advice": self.advice(),
            "phi": self._walkers.phi(nodes).tolist(),
            "node": nodes.tolist(),
            "graph_nodes": self._walkers.known().tolist(),
        }
        return [{name: column[i] for name, column in columns.items()} for i in range(self.num_envs)]


def _is_monitored(venv: VecEnv) -> bool:
    return is_vecenv_wrapped(venv, VecMonitor) or all(venv.env_is_wrapped(Monitor))


def _monitored(venv: VecEnv) -> VecEnv:
    if isinstance(venv, DummyVecEnv):
        venv.envs[:] = [Monitor(env) for env in venv.envs]
        return venv
    return VecMonitor(venv)


def _at(observations: Any, i: int) -> Any:
    """What environment ``i`` observed."""
    if isinstance(observations, dict):
        return {name: part[i] for name, part in observations.items()}
    if isinstance(observations, tuple):
        return tuple(part[i] for part in observations)
    return observations[i]


def _one(space: spaces.Space, observation: Any) -> Any:
    """An observation in the types of its space, in which vector environments hold it: last ones come as the environment gave
    them."""
    if isinstance(space, spaces.Dict):
        return {name: _one(part, observation[name]) for name, part in space.spaces.items()}
    if isinstance(space, spaces.Tuple):
        return tuple(_one(part, observation[j]) for j, part in enumerate(space.spaces))
    if isinstance(space, spaces.Discrete):
        return int(observation)
    return np.asarray(observation, dtype=space.dtype)


def _with_advice_space(space: spaces.Space, num_actions: int) -> spaces.Dict:
    advice = spaces.Box(-np.inf, np.inf, (num_actions,), np.float32)
    if isinstance(space, spaces.Dict):
        return spaces.Dict({**space.spaces, "advice": advice})
    return spaces.Dict({"observation": space, "advice": advice})


def _with_advice(observation: Any, advice: Floats) -> dict[str, Any]:
    parts = observation if isinstance(observation, dict) else {"observation": observation}
    return {**parts, "advice": np.asarray(advice, dtype=np.float32)}
