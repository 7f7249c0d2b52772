"""A Gymnasium environment with shaped rewards and advice."""

from __future__ import annotations

import sys
from typing import Any, SupportsFloat

import gymnasium as gym

from .engine import Engine
from .keys import KeyLike, Namer
from .saving import Saved
from .worlds import Worlds, require_choice, require_discrete


class Shaped(Saved, gym.Wrapper, gym.utils.RecordConstructorArgs):
    """An environment whose reward is shaped by what was discovered so far: R′ = R + γ φ(s′) − φ(s).

    - ``key``: how states are named. ``"obs"``, the observation; ``"minigrid"``, all that changes in a MiniGrid world;
      ``"minigrid-pose"``, the agent's pose alone; ``"topogym"``; a name given to :func:`eigentrail.register_key`; or a
      function of the environment, or of environment and observation (see :mod:`eigentrail.keys`).
    - ``gamma``: the discount of your learner. Shaping with another one changes what is optimal.
    - ``reward``: what ``step`` returns, ``"shaped"`` or ``"raw"``. Learners that take the raw one add
      ``info["shaping"]`` themselves.
    - ``monitor``: put Stable-Baselines3's ``Monitor`` inside, so that its curves are of raw returns; ``None`` does so
      if Stable-Baselines3 is in use and nothing inside keeps statistics yet.
    - ``seed``: of the engine. ``max_layouts``: how many layouts, each with a graph of its own, are kept in mind.
    - Other parameters are sections of a scenario; see :class:`eigentrail.Engine`.

    ``info`` has, after each reset and step: ``extrinsic_reward`` (the raw one), ``shaping`` (F), ``advice`` (one number
    per action, for the state that was reached), ``phi``, ``node`` (the state's number) and ``graph_nodes``.

    **Returns.** Statistics are of the rewards that the wrapper with the statistics sees: one *inside* (``RecordEpisodeStatistics``
    or ``Monitor`` applied before ``Shaped``) records raw returns, one outside what ``step`` returns.

    **Before the first goal** φ is flat and shaping is 0: what leads the search is ``advice``. It is mostly 0 afterwards; for this
    agent, which does nothing but follow it, it shall lead to the goal as well:

    >>> import gymnasium, eigentrail
    >>> lake = gymnasium.make("FrozenLake-v1", is_slippery=False)
    >>> env = eigentrail.Shaped(lake, key="obs", gamma=0.99, exploration={"potential_advice": 20.0})
    >>> observation, info = env.reset(seed=0)
    >>> for step in range(500):
    ...     action = int(info["advice"].argmax())
    ...     observation, reward, terminated, truncated, info = env.step(action)
    ...     if terminated or truncated:
    ...         observation, info = env.reset()
    >>> env.engine.num_nodes > 10, len(env.engine.goals())
    (True, 1)
    """

    def __init__(
        self,
        env: gym.Env,
        key: KeyLike = "obs",
        gamma: float = 0.99,
        *,
        reward: str = "shaped",
        monitor: bool | None = None,
        seed: int = 0,
        max_layouts: int = 64,
        **params: dict[str, Any],
    ) -> None:
        self._settings = {
            "key": key,
            "gamma": gamma,
            "reward": reward,
            "monitor": monitor,
            "seed": seed,
            "max_layouts": max_layouts,
            **params,
        }
        gym.utils.RecordConstructorArgs.__init__(self, **self._settings)
        gym.Wrapper.__init__(self, _monitored(env, monitor))
        require_choice("reward", reward, ("shaped", "raw"))
        num_actions, self._first_action = require_discrete(env.action_space)
        self.gamma = gamma
        self._returns_shaped = reward == "shaped"
        self._namer = Namer(key)
        self._worlds = Worlds(num_actions, gamma, seed, 1, max_layouts, params)
        self._engine: Engine | None = None

    @property
    def engine(self) -> Engine:
        """The engine of the present layout."""
        return self._engine or self._worlds.first

    @property
    def engines(self) -> list[Engine]:
        """Those of all layouts that are kept in mind, the latest last."""
        return list(self._worlds.engines.values())

    @property
    def spec(self) -> Any:
        """That of the environment with this wrapper, said to be nondeterministic: advice depends on earlier episodes."""
        spec = super().spec
        if spec is not None:
            spec.nondeterministic = True
        return spec

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begins an episode, in the graph of its layout."""
        observation, info = self.env.reset(seed=seed, options=options)
        engine = self._engine = self._worlds.of(self._namer.reset(self.env))
        node = engine.begin_episode(self._namer(self.env, observation))
        return observation, self._told(info, 0.0, 0.0, engine.phi(node), node)

    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """Takes a step, and takes it into the graph."""
        observation, reward, terminated, truncated, info = self.env.step(action)
        engine = self.engine
        seen = engine.observe(
            int(action) - self._first_action,
            self._namer(self.env, observation, bool(terminated)),
            float(reward),
            bool(terminated),
            bool(truncated),
        )
        self._worlds.watch.step(seen, engine)
        info = self._told(info, float(reward), seen.shaping, seen.phi, seen.node)
        if self._returns_shaped:
            reward = float(reward) + seen.shaping + seen.bonus
        return observation, reward, terminated, truncated, info

    def _told(self, info: dict[str, Any], reward: float, shaping: float, phi: float, node: int) -> dict[str, Any]:
        return {
            **info,
            "extrinsic_reward": reward,
            "shaping": shaping,
            "advice": self.engine.advice(),
            "phi": phi,
            "node": node,
            "graph_nodes": self.engine.num_nodes,
        }


def _monitored(env: gym.Env, monitor: bool | None) -> gym.Env:
    """With Stable-Baselines3's Monitor around it, if that is wanted."""
    in_use = "stable_baselines3" in sys.modules
    if monitor is False or (monitor is None and (not in_use or _keeps_statistics(env))):
        return env
    from stable_baselines3.common.monitor import Monitor

    return Monitor(env)


def _keeps_statistics(env: gym.Env) -> bool:
    while isinstance(env, gym.Wrapper):
        if type(env).__name__ in ("Monitor", "RecordEpisodeStatistics"):
            return True
        env = env.env
    return False
