"""The exact MDP of an environment, found by exploration, and what can be computed from it."""

from __future__ import annotations

import warnings
from collections import Counter, deque
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _eigentrail
from .engine import Engine, Floats, Integers
from .keys import KeyLike, Namer
from .names import canonical
from .worlds import require_discrete

Flags = npt.NDArray[np.bool_]

# Resets in a row that found nothing new, after which nothing is expected of further ones: starts may be drawn.
_BARREN_RESETS = 50


class Policy:
    """An action for every state: called with a state it gives the action, ``None`` where episodes are over.

    ``actions`` has them by the state's number, −1 where episodes are over.
    """

    def __init__(self, mdp: Mdp, actions: Integers) -> None:
        self._mdp = mdp
        self.actions = actions

    def __call__(self, state: Any) -> int | None:
        action = int(self.actions[self._mdp.number_of(state)])
        return None if action < 0 else action


class Solution(NamedTuple):
    """Optimal values of an MDP, and what follows from them."""

    gamma: float
    values: Floats
    """V*, by state."""
    q: Floats
    """Q*, states × actions; 0 where episodes are over."""
    policy: Policy
    """An optimal policy: of equally good actions the first."""
    optimal_return: float
    """Mean of V* over the starts."""

    def optimal_actions(self, number: int, tol: float = 1e-6) -> list[int]:
        """Every action that is as good as the best one in the state with this number; none where episodes are over."""
        if self.policy.actions[number] < 0:
            return []
        q = self.q[number]
        finite = np.abs(self.q[np.isfinite(self.q)])
        slack = tol * max(1.0, float(finite.max(initial=0.0)))
        return [int(action) for action in np.flatnonzero(q >= q.max() - slack)]


class Mdp:
    """A finite MDP as transitions, each an entry of equally long arrays.

    ``states`` are the values that the key gave, ``keys`` their canonical bytes; ``source``, ``action``, ``target``,
    ``count``, ``probability``, ``reward`` (the mean) and ``ends`` (the episode terminates) are the transitions;
    ``starts`` is the chance of each state to be the first one. ``complete`` says whether every action of every state
    that can be reached was tried often enough; ``exact`` whether probabilities are known rather than counted, or all 1.
    """

    def __init__(
        self,
        states: list[Any],
        keys: list[bytes],
        num_actions: int,
        first_action: int,
        transitions: list[tuple[int, int, int, int, float, float, bool]],
        starts: Floats,
        complete: bool,
        exact: bool,
    ) -> None:
        self.states = states
        self.keys = keys
        self.num_actions = num_actions
        self.first_action = first_action
        self.starts = starts
        self.complete = complete
        self.exact = exact
        columns = list(zip(*transitions, strict=True)) if transitions else [()] * 7
        kinds = (np.int64, np.int64, np.int64, np.int64, np.float64, np.float64, np.bool_)
        arrays: list[Any] = [np.array(column, dtype=kind) for column, kind in zip(columns, kinds, strict=True)]
        self.source: Integers = arrays[0]
        self.action: Integers = arrays[1]
        self.target: Integers = arrays[2]
        self.count: Integers = arrays[3]
        self.probability: Floats = arrays[4]
        self.reward: Floats = arrays[5]
        self.ends: Flags = arrays[6]
        self._numbers = {key: number for number, key in enumerate(keys)}
        self._solution: Solution | None = None

    @property
    def num_states(self) -> int:
        """How many states there are."""
        return len(self.states)

    @property
    def terminal(self) -> Flags:
        """States in which episodes are over: nothing follows them."""
        terminal = np.ones(self.num_states, dtype=bool)
        terminal[self.source] = False
        return terminal

    def number_of(self, state: Any) -> int:
        """The number of a state, given as the key names it."""
        number = self._numbers.get(canonical(state))
        if number is None:
            raise KeyError(f"the MDP has no state {state!r}")
        return number

    def solve(self, gamma: float = 1.0, tol: float = 1e-10) -> Solution:
        """V*, Q* and an optimal policy, by value iteration. Actions are numbered as the environment does."""
        solution = self._solved(self.reward, gamma, tol)
        self._solution = solution
        return solution

    @property
    def optimal_return(self) -> float:
        """What the best policy earns on average, with the gamma of the last :meth:`solve`, or 1."""
        return (self._solution or self.solve()).optimal_return

    @property
    def policy(self) -> Policy:
        """An optimal policy, with the gamma of the last :meth:`solve`, or 1."""
        return (self._solution or self.solve()).policy

    def _solved(self, reward: Floats, gamma: float, tol: float) -> Solution:
        if not self.complete:
            raise ValueError(
                "the MDP is not complete: some actions of states that can be reached were not tried often enough; explore "
                "with more max_steps"
            )
        values, q = _eigentrail.solve(
            self.num_states,
            self.num_actions,
            self.source * self.num_actions + self.action,
            self.target,
            self.probability,
            reward,
            self.ends,
            gamma,
            tol,
        )
        actions = np.where(self.terminal, -1, q.argmax(axis=1) + self.first_action)
        policy = Policy(self, actions)
        begun = self.starts > 0  # a state without a way to the end is worth −∞, and 0 · ∞ no number
        return Solution(gamma, values, q, policy, float(self.starts[begun] @ values[begun]))

    def __repr__(self) -> str:
        told = "" if self.complete else ", not complete"
        return f"<eigentrail.Mdp: {self.num_states} states, {len(self.source)} transitions{told}>"


def explore(
    env: Any,
    key: KeyLike = "obs",
    *,
    max_steps: int = 1_000_000,
    samples: int = 100,
    seed: int = 0,
) -> Mdp:
    """The MDP of an environment whose states can be named: every action is tried in every state that can be reached.

    Gymnasium's toy worlds tell their transitions, which are then taken as they are. Of others each action is tried once, and ``samples``
    times once an action has led to two places. Worlds with layouts are reset with ``seed`` each time, so that the layout
    stays; others draw their starts. With the keys of MiniGrid the clock is stopped, for its rewards fall with the time.

    >>> import gymnasium, eigentrail
    >>> mdp = eigentrail.explore(gymnasium.make("CliffWalking-v1"))
    >>> mdp.num_states, mdp.solve(gamma=1.0).optimal_return
    (38, -13.0)
    >>> mdp.policy(36)  # from the start, up
    0
    """
    num_actions, first_action = require_discrete(env.action_space)
    namer = Namer(key)
    if _tells_transitions(env, namer):
        return _from_table(env, num_actions, first_action)
    search = _Search(env, namer, num_actions, first_action, samples, seed)
    search.run(max_steps)
    return search.mdp()


def _tells_transitions(env: Any, namer: Namer) -> bool:
    """Whether the environment has a table of transitions, and nothing around it changes what it says."""
    plain = ("OrderEnforcing", "PassiveEnvChecker", "TimeLimit")
    inner = env
    while hasattr(inner, "env") and type(inner).__name__ in plain:
        inner = inner.env
    return (
        inner is env.unwrapped
        and not namer.needs_env
        and hasattr(inner, "P")
        and hasattr(inner, "initial_state_distrib")
        and not getattr(inner, "fickle_passenger", False)
    )


def _from_table(env: Any, num_actions: int, first_action: int) -> Mdp:
    table, chances = env.unwrapped.P, np.asarray(env.unwrapped.initial_state_distrib, dtype=np.float64)
    numbers: dict[int, int] = {}
    queue: deque[int] = deque()

    def number(state: int, goes_on: bool) -> int:
        numbers.setdefault(state, len(numbers))
        if goes_on and state not in opened:
            opened.add(state)
            queue.append(state)
        return numbers[state]

    opened: set[int] = set()
    for start in np.flatnonzero(chances).tolist():
        number(start, True)
    transitions = []
    while queue:
        state = queue.popleft()
        for action in range(num_actions):
            outcomes: dict[tuple[int, bool], list[float]] = {}
            for probability, target, reward, ends in table[state][action + first_action]:
                if probability > 0:
                    sums = outcomes.setdefault((int(target), bool(ends)), [0.0, 0.0])
                    sums[0] += probability
                    sums[1] += probability * reward
            for (target, ends), (probability, weighted) in outcomes.items():
                place = number(target, not ends)
                mean = weighted / probability
                transitions.append((numbers[state], action, place, 0, probability, mean, ends))
    states = list(numbers)
    starts = chances[states] / chances.sum()
    keys = [canonical(state) for state in states]
    return Mdp(states, keys, num_actions, first_action, transitions, starts, True, True)


class _Pair:
    """What came of one action in one state."""

    __slots__ = ("outcomes", "tries")

    def __init__(self) -> None:
        self.tries = 0
        # Target and end → count, sum of rewards, the least and the largest reward.
        self.outcomes: dict[tuple[int, bool], list[float]] = {}

    def ways(self) -> list[int]:
        """Where it led without ending the episode."""
        return [target for target, ends in self.outcomes if not ends]


class _Search:
    """A walk that goes to the nearest action that was not tried often enough, again and again."""

    def __init__(
        self, env: Any, namer: Namer, num_actions: int, first_action: int, samples: int, seed: int
    ) -> None:
        self.env = env
        self.namer = namer
        self.num_actions = num_actions
        self.first_action = first_action
        self.samples = samples
        self.seed = seed
        self.numbers: dict[bytes, int] = {}
        self.states: list[Any] = []
        self.pairs: list[list[_Pair]] = []
        self.starts: Counter[int] = Counter()
        self.needed = 1
        self.has_layout = False
        self.out_of_reach: set[int] = set()
        # By target, episodes that ended on the way to it.
        self.misses: Counter[int | None] = Counter()
        self.complete = False
        self.steps = 0

    def run(self, max_steps: int) -> None:
        here = self._reset(first=True)
        barren, tried = 0, False
        while self.steps < max_steps:
            plan, target = self._plan(here)
            if plan is None:
                barren += 1
                if barren > (0 if self.has_layout else _BARREN_RESETS):
                    self.complete = not self.out_of_reach
                    return
                here, tried = self._reset(), False
                continue
            barren, over = 0, False
            for action, expected in plan:
                tried |= self.pairs[here][action].tries < self.needed
                here, over = self._step(here, action)
                if over or here != expected:
                    break
            if over:
                if not tried:
                    self._miss(target)
                here, tried = self._reset(), False

    def _miss(self, target: int | None) -> None:
        """Where nothing is left to chance, an episode that ended too early will do so again."""
        self.misses[target] += 1
        if target is not None and self.misses[target] > (1 if self.needed == 1 else 20 * self.samples):
            self.out_of_reach.add(target)

    def mdp(self) -> Mdp:
        transitions = []
        varies = False
        for source, pairs in enumerate(self.pairs):
            for action, pair in enumerate(pairs):
                for (target, ends), (count, total, least, most) in pair.outcomes.items():
                    varies |= most - least > 1e-9
                    chance, mean = count / pair.tries, total / count
                    transitions.append((source, action, target, int(count), chance, mean, ends))
        if varies:
            warnings.warn(
                "some transitions paid now more and now less, as with rewards that fall with time: their means stand in the MDP",
                UserWarning,
                stacklevel=3,
            )
        starts = np.zeros(len(self.states))
        for number, count in self.starts.items():
            starts[number] = count
        keys = list(self.numbers)
        args = (self.states, keys, self.num_actions, self.first_action, transitions, starts / starts.sum())
        return Mdp(*args, self.complete, self.needed == 1)

    def _reset(self, first: bool = False) -> int:
        seeded = first or self.has_layout
        observation, _ = self.env.reset(seed=self.seed) if seeded else self.env.reset()
        self.has_layout = self.namer.reset(self.env) is not None
        here = self._number(observation)
        self.starts[here] += 1
        return here

    def _number(self, observation: Any, terminated: bool = False) -> int:
        state = self.namer.state(self.env, observation, terminated)
        name = canonical(state)
        number = self.numbers.setdefault(name, len(self.numbers))
        if number == len(self.states):
            self.states.append(state)
            self.pairs.append([_Pair() for _ in range(self.num_actions)])
        return number

    def _step(self, here: int, action: int) -> tuple[int, bool]:
        self.namer.stop_clock(self.env)
        observation, reward, terminated, truncated, _ = self.env.step(action + self.first_action)
        self.steps += 1
        there, reward = self._number(observation, bool(terminated)), float(reward)
        pair = self.pairs[here][action]
        pair.tries += 1
        seen = pair.outcomes.setdefault((there, bool(terminated)), [0, 0.0, reward, reward])
        seen[0] += 1
        seen[1] += reward
        seen[2], seen[3] = min(seen[2], reward), max(seen[3], reward)
        if len(pair.outcomes) > 1:
            self.needed = self.samples
        return there, bool(terminated or truncated)

    def _plan(self, here: int) -> tuple[list[tuple[int, int | None]] | None, int | None]:
        """Actions to the nearest state with something to try, and what to try there; with the states expected on the way."""
        came: dict[int, tuple[int, int]] = {here: (-1, -1)}
        queue = deque([here])
        while queue:
            state = queue.popleft()
            if state not in self.out_of_reach:
                for action, pair in enumerate(self.pairs[state]):
                    if pair.tries < self.needed:
                        return [*self._way(came, state), (action, None)], state
            for action, pair in enumerate(self.pairs[state]):
                for target in pair.ways():
                    if target not in came:
                        came[target] = (state, action)
                        queue.append(target)
        return None, None

    @staticmethod
    def _way(came: dict[int, tuple[int, int]], state: int) -> list[tuple[int, int | None]]:
        way: list[tuple[int, int | None]] = []
        while came[state][0] >= 0:
            before, action = came[state]
            way.append((action, state))
            state = before
        return way[::-1]


class CheckedState(NamedTuple):
    """The optimal actions of one state, without and with shaping."""

    state: Any
    before: list[int]
    after: list[int]

    @property
    def kept(self) -> bool:
        return self.before == self.after


class ShapingCheck:
    """Whether a shaping keeps the optimal actions, ties included.

    ``kept`` is the answer (and the truth value of the whole); ``states`` has a :class:`CheckedState` for each state in
    which there is something to decide; ``changed`` those of them whose optimal actions are others with shaping;
    ``reasons`` what can be said about why.
    """

    def __init__(self, states: list[CheckedState], reasons: list[str]) -> None:
        self.states = states
        self.changed = [state for state in states if not state.kept]
        self.kept = not self.changed
        self.reasons = reasons

    def __bool__(self) -> bool:
        return self.kept

    def __str__(self) -> str:
        count = len(self.states)
        if self.kept:
            return f"the optimal actions of all {count} states are kept"
        lines = [f"the optimal actions of {len(self.changed)} of {count} states change"]
        lines += [f"  {state.state!r}: {state.before} become {state.after}" for state in self.changed[:20]]
        lines += [f"  … and {len(self.changed) - 20} more"] if len(self.changed) > 20 else []
        return "\n".join(lines + self.reasons)


def check_shaping(
    mdp: Mdp,
    phi: Any,
    gamma: float,
    *,
    shaping_gamma: float | None = None,
    tol: float = 1e-6,
) -> ShapingCheck:
    """Does this shaping keep these optimal actions, ties included? Both problems are solved, and compared state by state.

    ``phi`` is a number for each state: an array by number, a mapping from states, or a function of states. It is taken as it is,
    also where episodes end: unless it is 0 there, shaping can change what is optimal, and that is what this finds. An
    :class:`eigentrail.Engine`, or an environment in :class:`eigentrail.Shaped`, stands for its φ, which is 0 at ends.
    ``shaping_gamma`` is the discount in F = γ φ(s′) − φ(s) if it is another one than the learner's.

    >>> import gymnasium, eigentrail
    >>> mdp = eigentrail.explore(gymnasium.make("FrozenLake-v1", is_slippery=False))
    >>> str(eigentrail.check_shaping(mdp, lambda state: 0.0 if mdp.terminal[mdp.number_of(state)] else -state, gamma=0.9))
    'the optimal actions of all 11 states are kept'
    >>> check = eigentrail.check_shaping(mdp, lambda state: 10.0 * (state == 5), gamma=0.9)
    >>> check.kept, check.reasons
    (False, ['φ is not 0 at 1 of 5 states in which episodes end'])
    """
    inside, at_end = _potential(mdp, phi)
    discount = gamma if shaping_gamma is None else shaping_gamma
    arrived = np.where(mdp.ends, at_end[mdp.target], inside[mdp.target])
    shaping = discount * arrived - inside[mdp.source]
    plain = mdp._solved(mdp.reward, gamma, 1e-12)
    shaped = mdp._solved(mdp.reward + shaping, gamma, 1e-12)
    decided = np.flatnonzero(~mdp.terminal).tolist()
    states = [
        CheckedState(mdp.states[i], plain.optimal_actions(i, tol), shaped.optimal_actions(i, tol)) for i in decided
    ]
    reasons = []
    ended = np.unique(mdp.target[mdp.ends])
    away = int(np.count_nonzero(at_end[ended]))
    if away:
        reasons.append(f"φ is not 0 at {away} of {len(ended)} states in which episodes end")
    if discount != gamma:
        reasons.append(f"shaping discounts by {discount}, the learner by {gamma}")
    return ShapingCheck(states, reasons)


def _potential(mdp: Mdp, phi: Any) -> tuple[Floats, Floats]:
    """φ of each state while the episode goes on, and where it ends."""
    engine = phi if isinstance(phi, Engine) else getattr(phi, "engine", None)
    if isinstance(engine, Engine):
        return np.array([engine.phi(key) for key in mdp.keys]), np.zeros(mdp.num_states)
    if isinstance(phi, Mapping):
        values = [phi[state] for state in mdp.states]
    elif callable(phi):
        values = [phi(state) for state in mdp.states]
    else:
        values = phi
    array = np.asarray(values, dtype=np.float64)
    if array.shape != (mdp.num_states,):
        raise ValueError(f"phi has shape {array.shape}: must be one number for each of {mdp.num_states} states")
    if not np.isfinite(array).all():
        raise ValueError("phi is not finite everywhere")
    return array, array
