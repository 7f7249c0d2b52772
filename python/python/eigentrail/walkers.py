"""Many walkers, each in the world model of its layout, and the names of where they are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import gymnasium as gym
import numpy as np

from .engine import Engine, Floats, Integers, Observed
from .keys import KeyLike, Namer
from .worlds import Worlds


class Walkers:
    """Walkers who share what they find out, as far as their layouts are the same."""

    def __init__(
        self,
        number: int,
        actions: tuple[int, int],
        gamma: float,
        seed: int,
        max_layouts: int,
        params: dict[str, Any],
    ) -> None:
        num_actions, self._first_action = actions
        self.worlds = Worlds(num_actions, gamma, seed, number, max_layouts, params)
        self._present: list[Engine | None] = [None] * number

    @property
    def engines(self) -> list[Engine]:
        """Of each walker, the engine of its layout."""
        return [engine or self.worlds.first for engine in self._present]

    def begin(self, i: int, layout: bytes | None, name: bytes) -> int:
        """Walker ``i`` begins an episode; the number of the state where it does."""
        engine = self._present[i] = self.worlds.of(layout)
        return engine.begin_episode(name, i)

    def observe(
        self, i: int, action: Any, name: bytes, reward: float, terminated: bool, truncated: bool
    ) -> Observed:
        """Takes in a step of walker ``i``; ``action`` is numbered as the environment does."""
        engine = self._present[i] or self.worlds.first
        action = int(action) - self._first_action
        seen = engine.observe(action, name, float(reward), bool(terminated), bool(truncated), i)
        self.worlds.watch.step(seen, engine)
        return seen

    def nodes(self) -> Integers:
        """Where they stand; 0 before the first episode."""
        return np.array([engine.node(i) or 0 for i, engine in enumerate(self.engines)], dtype=np.int64)

    def phi(self, nodes: Integers) -> Floats:
        """φ of a state of each walker's world."""
        return np.array([engine.phi(int(node)) for engine, node in zip(self.engines, nodes, strict=True)])

    def advice(self) -> Floats:
        """Walkers × actions: advice for where they stand."""
        return np.stack([engine.advice(i) for i, engine in enumerate(self.engines)])

    def known(self) -> Integers:
        """How many states each walker's world has."""
        return np.array([engine.num_nodes for engine in self.engines], dtype=np.int64)


class Noted(gym.Wrapper):
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


class Names(Protocol):
    """Names of where the environments are."""

    def see(self, observations: Sequence[Any], final: dict[int, Any]) -> None:
        """To be called with what each step or reset brings: the present observations, and for environments that have begun
        another episode in the same step the last one of the old episode."""

    def reached(self, i: int) -> bytes:
        """Where the last step of environment ``i`` led."""

    def begun(self, i: int) -> tuple[bytes | None, bytes]:
        """The layout of its episode, if the key knows layouts, and where it began."""


class NamesInside:
    """Names told by the environments themselves."""

    needs_observations = False

    def __init__(self, noted: list[Noted]) -> None:
        self._noted = noted

    def see(self, observations: Sequence[Any], final: dict[int, Any]) -> None:
        pass

    def reached(self, i: int) -> bytes:
        return self._noted[i].last

    def begun(self, i: int) -> tuple[bytes | None, bytes]:
        return self._noted[i].layout, self._noted[i].start


class NamesOfObservations:
    """Names made of observations, for environments that cannot be looked into."""

    needs_observations = True

    def __init__(self, namer: Namer) -> None:
        self._namer = namer
        self._present: Sequence[Any] = ()
        self._final: dict[int, Any] = {}

    def see(self, observations: Sequence[Any], final: dict[int, Any]) -> None:
        self._present, self._final = observations, final

    def reached(self, i: int) -> bytes:
        return self._namer(None, self._final.get(i, self._present[i]))

    def begun(self, i: int) -> tuple[bytes | None, bytes]:
        return None, self._namer(None, self._present[i])


def names(envs: Any, key: KeyLike, instead: str) -> NamesInside | NamesOfObservations:
    """Names for a vector environment: told from inside if its list ``envs`` is here, else by observations.

    ``instead`` is the kind of vector environment to take where the key has to look inside and cannot.
    """
    inside = getattr(envs, "envs", None)
    if isinstance(inside, list) and all(isinstance(env, gym.Env) for env in inside):
        inside[:] = [Noted(env, key) for env in inside]
        return NamesInside(inside)
    namer = Namer(key)
    if namer.needs_env:
        raise TypeError(
            f"the key has to look into the environments of {type(envs).__name__}, which are elsewhere: use "
            f'"obs", or a {instead}'
        )
    return NamesOfObservations(namer)
