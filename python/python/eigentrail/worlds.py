"""What the wrappers of one and of many environments share: engines by layout, and warnings."""

from __future__ import annotations

import warnings
from collections import OrderedDict
from typing import Any

from .engine import Engine, Observed

_STEPS_BEFORE_JUDGING = 1000
_EPISODES_BEFORE_JUDGING = 20


def require_discrete(space: Any) -> tuple[int, int]:
    """How many actions a Gymnasium space has, and the first one's number."""
    from gymnasium.spaces import Discrete

    if not isinstance(space, Discrete):
        raise TypeError(f"the action space is {space}: eigentrail needs finitely many actions (Discrete)")
    return int(space.n), int(space.start)


def require_choice(name: str, value: Any, choices: tuple[Any, ...]) -> None:
    if value not in choices:
        told = ", ".join(repr(choice) for choice in choices)
        raise ValueError(f"{name} = {value!r}: must be one of {told}")


class Worlds:
    """An engine for each layout, made when the layout is first seen; of many layouts the latest ones."""

    def __init__(
        self, num_actions: int, gamma: float, seed: int, walkers: int, max_layouts: int, params: dict[str, Any]
    ) -> None:
        if max_layouts < 1:
            raise ValueError(f"max_layouts = {max_layouts}: must be at least 1")
        self._made_of = (num_actions, gamma, seed, walkers, params)
        self._max_layouts = max_layouts
        self.engines: OrderedDict[bytes | None, Engine] = OrderedDict()
        self.watch = Watch()
        # Parameters are checked here and not at the first reset; this is the engine of the first layout.
        self._unused: Engine | None = self._make()

    def _make(self) -> Engine:
        num_actions, gamma, seed, walkers, params = self._made_of
        return Engine(num_actions, gamma, seed=seed, walkers=walkers, **params)

    @property
    def first(self) -> Engine:
        """The engine that there is before the first reset."""
        return self._unused if self._unused is not None else next(reversed(self.engines.values()))

    def of(self, layout: bytes | None) -> Engine:
        """The engine of a layout."""
        is_new = layout not in self.engines
        if is_new:
            self.engines[layout] = self._unused if self._unused is not None else self._make()
            self._unused = None
        self.engines.move_to_end(layout)
        if len(self.engines) > self._max_layouts:
            self.engines.popitem(last=False)
        self.watch.begin_episode(is_new)
        return self.engines[layout]


    def take_up(self, engines: list[tuple[bytes | None, bytes]]) -> None:
        """Goes on with engines that were saved."""
        walkers = self._made_of[3]
        for layout, saved in engines:
            engine = Engine.from_bytes(saved)
            if engine.num_walkers != walkers:
                raise ValueError(f"saved with {engine.num_walkers} environments, not {walkers}")
            if engine.num_actions != self._made_of[0]:
                raise ValueError(f"saved with {engine.num_actions} actions, not {self._made_of[0]}")
            self.engines[layout] = engine
            self._unused = None


class Watch:
    """Warnings, each given once."""

    def __init__(self) -> None:
        self._steps = self._new_nodes = 0
        self._episodes = self._new_layouts = 0
        self._is_ambiguous = False

    def begin_episode(self, new_layout: bool) -> None:
        self._episodes += 1
        self._new_layouts += new_layout
        if self._episodes == self._new_layouts == _EPISODES_BEFORE_JUDGING:
            _warn(
                f"each of {self._episodes} episodes had a layout that was new: its graph starts from nothing every time. "
                "Fix the layout (MiniGrid: ReseedWrapper), or wait until layouts repeat"
            )

    def step(self, seen: Observed, engine: Engine) -> None:
        self._steps += 1
        self._new_nodes += seen.new_node
        if self._steps == _STEPS_BEFORE_JUDGING and self._new_nodes >= 0.99 * self._steps:
            _warn(
                f"{self._new_nodes} of {self._steps} steps led to a state that was never seen: nothing can be learnt of "
                "states that do not repeat. Take a key that leaves out clocks and counters, and cuts real numbers into cells"
            )
        if engine.ambiguous is not None and not self._is_ambiguous:
            self._is_ambiguous = True
            node, action = engine.ambiguous
            _warn(
                f"the key gives one name to states that behave differently: what action {action} does in the state with "
                f"the key {engine.key_of(node)!r} depends on how it was reached. Take a key that names all that matters"
            )


def _warn(text: str) -> None:
    warnings.warn(text, UserWarning, stacklevel=4)
