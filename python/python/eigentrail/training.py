"""The built-in agent on a Gymnasium environment."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from . import _eigentrail
from .keys import KeyLike, Namer
from .names import canonical
from .worlds import Watch, require_discrete

_EPISODE = np.dtype(
    [
        ("end_step", np.int64),
        ("length", np.int64),
        ("return", np.float64),
        ("shaped_return", np.float64),
        ("terminated", np.bool_),
        ("nodes", np.int64),
    ]
)


class Result:
    """What came of :func:`train`.

    - ``first_goal_step``: the step, counted from 1, at which a goal was entered first; ``None`` if never.
    - ``steps``: environment steps taken. ``nodes``: states discovered.
    - ``episodes``: a table, one row for each episode that came to its end, as a NumPy array with the columns
      ``end_step``, ``length``, ``return`` (raw), ``shaped_return``, ``terminated`` and ``nodes``;
      ``pandas.DataFrame(result.episodes)`` takes it as it is.
    """

    def __init__(
        self, learner: Any, first_action: int, first_goal_step: int | None, steps: int, rows: list[tuple[Any, ...]]
    ) -> None:
        self._learner = learner
        self._first_action = first_action
        self.first_goal_step = first_goal_step
        self.steps = steps
        self.nodes: int = learner.num_nodes
        self.episodes = np.array(rows, dtype=_EPISODE)

    def policy(self, state: Any) -> int | None:
        """The action that the agent thinks best in a state of the first layout, given as the key names it (with the key ``"obs"``, an
        observation); ``None`` in a state of which it knows nothing."""
        action = self._learner.greedy(canonical(state))
        return None if action is None else action + self._first_action

    def __repr__(self) -> str:
        return (
            f"<eigentrail.Result: {self.steps} steps, {len(self.episodes)} episodes, {self.nodes} nodes, "
            f"first goal at step {self.first_goal_step}>"
        )


def train(
    env: Any,
    key: KeyLike = "obs",
    gamma: float = 1.0,
    max_steps: int = 100_000,
    seed: int = 0,
    *,
    agent: dict[str, Any] | None = None,
    **params: dict[str, Any],
) -> Result:
    """Runs the built-in agent for ``max_steps`` steps. The environment need not be wrapped; it is reset with ``seed`` the
    first time.

    ``agent`` and the other parameters are sections of a scenario; see :class:`eigentrail.Engine`. Each layout of a
    world that has several is learnt by itself.

    In MiniGrid a goal pays 1 - 0.9 t/T, where T is the step limit, and t is no part of the name of a state: to a learner without
    discount it would not matter when it arrives. With MiniGrid's keys it learns from what the goal pays at once, and where ``gamma``
    is 1 it is discounted by the factor γ with γ^T = 0.1, which is what the goal pays at the limit. Since no goal pays more than 1
    (``exploration["reward_bound"]``), it looks for no other one once it has found one. ``episodes["return"]`` is the raw return all the same.

    >>> import gymnasium, eigentrail
    >>> env = gymnasium.make("FrozenLake-v1", is_slippery=False)
    >>> result = eigentrail.train(env, key="obs", max_steps=2000)
    >>> result.first_goal_step is not None, result.nodes > 10
    (True, True)
    >>> state, path = 0, []
    >>> while state != 15 and len(path) < 6:
    ...     path.append(result.policy(state))
    ...     state = env.unwrapped.P[state][path[-1]][0][1]
    >>> state, len(path)
    (15, 6)
    """
    num_actions, first_action = require_discrete(env.action_space)
    namer = Namer(key)
    limit = _step_limit(env)
    if namer.knows_clock and gamma == 1.0:
        gamma = 0.1 ** (1 / limit) if limit else 0.99
    if namer.reward_bound is not None:
        params["exploration"] = {"reward_bound": namer.reward_bound, **params.get("exploration", {})}
    learner = _eigentrail.Learner(num_actions, gamma, seed, limit, json.dumps(params), json.dumps(agent or {}))

    named = _Named(env, namer)
    rows: list[tuple[Any, ...]] = []
    first_goal_step: int | None = None
    length, plain, shaped = 0, 0.0, 0.0
    learner.begin_episode(named.begin(env.reset(seed=seed)[0]))
    for step in range(1, max_steps + 1):
        observation, reward, terminated, truncated, _ = env.step(learner.act() + first_action)
        reward = float(reward)
        reached, timeless = named.name(observation, bool(terminated)), namer.timeless(env, reward)
        seen = learner.learn(reached, timeless, bool(terminated), bool(truncated))
        _, shaping, _, _, first_goal, _, bonus, _ = seen
        if first_goal and first_goal_step is None:
            first_goal_step = step
        length, plain, shaped = length + 1, plain + reward, shaped + timeless + shaping + bonus
        if terminated or truncated:
            rows.append((step, length, plain, shaped, bool(terminated), learner.num_nodes))
            length, plain, shaped = 0, 0.0, 0.0
            if step < max_steps:
                learner.begin_episode(named.begin(env.reset()[0]))
    return Result(learner, first_action, first_goal_step, max_steps, rows)


class _Named:
    """States of an environment: those of the first layout by their names, those of others with the layout's before it."""

    def __init__(self, env: Any, namer: Namer) -> None:
        self._env = env
        self._namer = namer
        self._layouts: dict[bytes | None, bytes] = {}
        self._prefix = b""
        self._watch = Watch()

    def begin(self, observation: Any) -> bytes:
        layout = self._namer.reset(self._env)
        is_new = layout not in self._layouts
        self._prefix = self._layouts.setdefault(layout, (layout or b"") if self._layouts else b"")
        self._watch.begin_episode(is_new)
        return self.name(observation)

    def name(self, observation: Any, terminated: bool = False) -> bytes:
        return self._prefix + self._namer(self._env, observation, terminated)


def _step_limit(env: Any) -> int | None:
    """After how many steps episodes are cut off, if that is known."""
    spec = getattr(env, "spec", None)
    limit = spec.max_episode_steps if spec is not None else None
    limit = limit or getattr(env.unwrapped, "max_steps", None)
    return int(limit) if isinstance(limit, (int, np.integer)) and limit >= 1 else None
