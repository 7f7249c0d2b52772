"""Vector environments: many walkers on one world model."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv, VectorWrapper
from gymnasium.vector.utils import iterate

from .engine import Engine
from .keys import KeyLike
from .saving import Saved
from .walkers import Walkers, names
from .worlds import require_choice, require_discrete


class ShapedVec(Saved, VectorWrapper, gym.utils.RecordConstructorArgs):
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
        self._settings = {
            "key": key,
            "gamma": gamma,
            "reward": reward,
            "seed": seed,
            "max_layouts": max_layouts,
            **params,
        }
        gym.utils.RecordConstructorArgs.__init__(self, **self._settings)
        VectorWrapper.__init__(self, envs)
        require_choice("reward", reward, ("shaped", "raw"))
        actions = require_discrete(envs.single_action_space)
        self.gamma = gamma
        self._returns_shaped = reward == "shaped"
        self._mode = AutoresetMode(envs.metadata.get("autoreset_mode", AutoresetMode.NEXT_STEP))
        self._walkers = Walkers(envs.num_envs, actions, gamma, seed, max_layouts, params)
        self._worlds = self._walkers.worlds
        self._names = names(envs.unwrapped, key, "SyncVectorEnv")
        self._over = np.zeros(envs.num_envs, dtype=bool)

    @property
    def engine(self) -> Engine:
        """The engine of the layout in which an episode was begun last; of worlds with one layout, the only one."""
        return self._worlds.first

    @property
    def engines(self) -> list[Engine]:
        """Of each environment, the engine of its layout."""
        return list(self._walkers.engines)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begins episodes in all environments, or in those of ``options["reset_mask"]``."""
        mask = (options or {}).get("reset_mask")
        # Some vector environments take the mask out of the options that they are given.
        observations, infos = self.env.reset(seed=seed, options=None if options is None else dict(options))
        self._see(observations, {})
        nodes = self._walkers.nodes()
        for i in range(self.num_envs) if mask is None else np.flatnonzero(mask):
            nodes[i] = self._begin(int(i))
        zeros = np.zeros(self.num_envs)
        return observations, self._told(infos, zeros, zeros.copy(), nodes)

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """Takes a step in every environment, and takes them all into the graph."""
        observations, rewards, terminated, truncated, infos = self.env.step(actions)
        ended = np.logical_or(terminated, truncated)
        has_begun = ended if self._mode is AutoresetMode.SAME_STEP else np.zeros_like(ended)
        self._see(observations, {int(i): infos["final_obs"][i] for i in np.flatnonzero(has_begun)})
        raw = np.asarray(rewards, dtype=np.float64)
        shaping, bonus = np.zeros(self.num_envs), np.zeros(self.num_envs)
        nodes = self._walkers.nodes()
        for i in range(self.num_envs):
            if self._over[i]:  # NEXT_STEP: this step has only begun the next episode
                nodes[i] = self._begin(i)
                continue
            seen = self._walkers.observe(
                i, actions[i], self._names.reached(i), raw[i], terminated[i], truncated[i]
            )
            shaping[i], bonus[i], nodes[i] = seen.shaping, seen.bonus, seen.node
            if ended[i] and self._mode is AutoresetMode.SAME_STEP:
                nodes[i] = self._begin(i)
            elif ended[i] and self._mode is AutoresetMode.NEXT_STEP:
                self._over[i] = True
        if self._returns_shaped:
            rewards = raw + shaping + bonus
        return observations, rewards, terminated, truncated, self._told(infos, raw, shaping, nodes, terminated)

    def _see(self, observations: Any, final: dict[int, Any]) -> None:
        if self._names.needs_observations:
            self._names.see(list(iterate(self.observation_space, observations)), final)

    def _begin(self, i: int) -> int:
        self._over[i] = False
        return self._walkers.begin(i, *self._names.begun(i))

    def _told(
        self,
        infos: dict[str, Any],
        rewards: np.ndarray,
        shaping: np.ndarray,
        nodes: np.ndarray,
        terminated: np.ndarray | None = None,
    ) -> dict[str, Any]:
        everywhere = np.ones(self.num_envs, dtype=bool)
        phi = self._walkers.phi(nodes)
        if terminated is not None and self._mode is not AutoresetMode.SAME_STEP:
            phi[np.asarray(terminated, dtype=bool)] = 0.0
        told = {
            "extrinsic_reward": rewards.copy(),
            "shaping": shaping,
            "advice": self._walkers.advice(),
            "phi": phi,
            "node": nodes,
            "graph_nodes": self._walkers.known(),
        }
        masks = {f"_{name}": everywhere.copy() for name in told}
        return {**infos, **told, **masks}
