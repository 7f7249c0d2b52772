"""Vector environments: many walkers on one world model."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv, VectorWrapper
from gymnasium.vector.utils import iterate

from .engine import Engine
from .keys import KeyLike, Namer
from .worlds import Worlds, require_choice, require_discrete


class ShapedVec(VectorWrapper, gym.utils.RecordConstructorArgs):
    """A vector environment with shaped rewards. What one of its environments finds out, all of them know.

    Parameters are those of :class:`eigentrail.Shaped`, and ``info`` has the same names, with an array each. A key other
    than ``"obs"`` has to look into the environments, which those of a ``SyncVectorEnv`` allow.

    All three autoreset modes are understood. In ``NEXT_STEP``, the step that only resets has ``shaping`` 0. In
    ``SAME_STEP``, ``shaping`` is that of the step that ended the episode; ``node``, ``phi`` and ``advice`` are of the
    state in which the next one begins.

    >>> import gymnasium, eigentrail
    >>> envs = gymnasium.make_vec("FrozenLake-v1", num_envs=4, vectorization_mode="sync", is_slippery=False)
    >>> envs = eigentrail.ShapedVec(envs, key="obs", gamma=0.99)
    >>> observations, info = envs.reset(seed=0)
    >>> for step in range(100):
    ...     observations, rewards, terminated, truncated, info = envs.step(info["advice"].argmax(axis=1))
    >>> info["shaping"].shape, info["advice"].shape
    ((4,), (4, 4))
    >>> envs.engine.num_walkers, envs.engine.num_nodes > 10
    (4, True)
    """

    def __init__(
        self,
        envs: VectorEnv,
        key: KeyLike = "obs",
        gamma: float = 0.99,
        *,
        reward: str = "shaped",
        seed: int = 0,
        max_layouts: int = 64,
        **params: dict[str, Any],
    ) -> None:
        gym.utils.RecordConstructorArgs.__init__(
            self, key=key, gamma=gamma, reward=reward, seed=seed, max_layouts=max_layouts, **params
        )
        VectorWrapper.__init__(self, envs)
        require_choice("reward", reward, ("shaped", "raw"))
        num_actions, self._first_action = require_discrete(envs.single_action_space)
        self.gamma = gamma
        self._returns_shaped = reward == "shaped"
        self._mode = AutoresetMode(envs.metadata.get("autoreset_mode", AutoresetMode.NEXT_STEP))
        self._names = _namers(envs, key)
        self._worlds = Worlds(num_actions, gamma, seed, envs.num_envs, max_layouts, params)
        self._engines = [self._worlds.first] * envs.num_envs
        self._over = np.zeros(envs.num_envs, dtype=bool)

    @property
    def engine(self) -> Engine:
        """The engine of the layout in which an episode was begun last; of worlds with one layout, the only one."""
        return self._worlds.first

    @property
    def engines(self) -> list[Engine]:
        """Of each environment, the engine of its layout."""
        return list(self._engines)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begins episodes in all environments, or in those of ``options["reset_mask"]``."""
        mask = (options or {}).get("reset_mask")
        # Some vector environments take the mask out of the options that they are given.
        observations, infos = self.env.reset(seed=seed, options=None if options is None else dict(options))
        self._names.see(observations, infos, None)
        nodes = self._where()
        for i in range(self.num_envs) if mask is None else np.flatnonzero(mask):
            nodes[i] = self._begin(int(i))
        zeros = np.zeros(self.num_envs)
        return observations, self._told(infos, zeros, zeros.copy(), nodes)

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Takes a step in every environment, and takes them all into the graph."""
        observations, rewards, terminated, truncated, infos = self.env.step(actions)
        ended = np.logical_or(terminated, truncated)
        self._names.see(observations, infos, ended if self._mode is AutoresetMode.SAME_STEP else None)
        raw = np.asarray(rewards, dtype=np.float64)
        shaping, bonus = np.zeros(self.num_envs), np.zeros(self.num_envs)
        nodes = self._where()
        for i in range(self.num_envs):
            if self._over[i]:  # NEXT_STEP: this step has only begun the next episode
                nodes[i] = self._begin(i)
                continue
            engine = self._engines[i]
            action = int(actions[i]) - self._first_action
            seen = engine.observe(
                action, self._names.reached(i), float(raw[i]), bool(terminated[i]), bool(truncated[i]), i
            )
            self._worlds.watch.step(seen, engine)
            shaping[i], bonus[i], nodes[i] = seen.shaping, seen.bonus, seen.node
            if ended[i] and self._mode is AutoresetMode.SAME_STEP:
                nodes[i] = self._begin(i)
            elif ended[i] and self._mode is AutoresetMode.NEXT_STEP:
                self._over[i] = True
        if self._returns_shaped:
            rewards = raw + shaping + bonus
        return observations, rewards, terminated, truncated, self._told(infos, raw, shaping, nodes, terminated)

    def _where(self) -> np.ndarray:
        return np.array([engine.node(i) or 0 for i, engine in enumerate(self._engines)], dtype=np.int64)

    def _begin(self, i: int) -> int:
        layout, name = self._names.begun(i)
        self._engines[i] = self._worlds.of(layout)
        self._over[i] = False
        return self._engines[i].begin_episode(name, i)

    def _told(
        self,
        infos: dict[str, Any],
        rewards: np.ndarray,
        shaping: np.ndarray,
        nodes: np.ndarray,
        terminated: np.ndarray | None = None,
    ) -> dict[str, Any]:
        everywhere = np.ones(self.num_envs, dtype=bool)
        phi = np.array([e.phi(int(n)) for e, n in zip(self._engines, nodes, strict=True)])
        if terminated is not None and self._mode is not AutoresetMode.SAME_STEP:
            phi[np.asarray(terminated, dtype=bool)] = 0.0
        told = {
            "extrinsic_reward": rewards.copy(),
            "shaping": shaping,
            "advice": np.stack([engine.advice(i) for i, engine in enumerate(self._engines)]),
            "phi": phi,
            "node": nodes,
            "graph_nodes": np.array([engine.num_nodes for engine in self._engines], dtype=np.int64),
        }
        masks = {f"_{name}": everywhere.copy() for name in told}
        return {**infos, **told, **masks}


class _Noted(gym.Wrapper):
    """Names the states of one environment as they come, before anything is reset."""

    def __init__(self, env: gym.Env, key: KeyLike) -> None:
        super().__init__(env)
        self._namer = Namer(key)
        self.layout: bytes | None = None
        self.start = self.last = b""

    def reset(self, **kwargs: Any) -> tuple[Any, dict[str, Any]]:
        observation, info = self.env.reset(**kwargs)
        self.layout = self._namer.reset(self.env)
        self.start = self._namer(self.env, observation)
        return observation, info

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        result = self.env.step(action)
        self.last = self._namer(self.env, result[0], bool(result[2]))
        return result


class _NamesInside:
    """Names told by the environments themselves."""

    def __init__(self, noted: list[_Noted]) -> None:
        self._noted = noted

    def see(self, observations: Any, infos: dict[str, Any], ended: np.ndarray | None) -> None:
        pass

    def reached(self, i: int) -> bytes:
        return self._noted[i].last

    def begun(self, i: int) -> tuple[bytes | None, bytes]:
        return self._noted[i].layout, self._noted[i].start


class _NamesOfObservations:
    """Names made of observations, for environments that cannot be looked into."""

    def __init__(self, space: gym.Space, namer: Namer) -> None:
        self._space = space
        self._namer = namer
        self._present: list[Any] = []
        self._final: dict[int, Any] = {}

    def see(self, observations: Any, infos: dict[str, Any], ended: np.ndarray | None) -> None:
        self._present = list(iterate(self._space, observations))
        self._final = {}
        if ended is not None and ended.any():
            final = infos["final_obs"]
            self._final = {int(i): final[i] for i in np.flatnonzero(ended)}

    def reached(self, i: int) -> bytes:
        return self._namer(None, self._final.get(i, self._present[i]))

    def begun(self, i: int) -> tuple[bytes | None, bytes]:
        return None, self._namer(None, self._present[i])


def _namers(envs: VectorEnv, key: KeyLike) -> _NamesInside | _NamesOfObservations:
    inside = getattr(envs.unwrapped, "envs", None)
    if isinstance(inside, list) and all(isinstance(env, gym.Env) for env in inside):
        inside[:] = [_Noted(env, key) for env in inside]
        return _NamesInside(inside)
    namer = Namer(key)
    if namer.needs_env:
        raise TypeError(
            f"the key has to look into the environments of {type(envs.unwrapped).__name__}, which are elsewhere: use "
            '"obs", or a SyncVectorEnv'
        )
    return _NamesOfObservations(envs.observation_space, namer)
