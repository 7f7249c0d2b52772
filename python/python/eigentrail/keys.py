"""Keys: functions that name the state that an environment is in.

A key is called as ``key(env)``, or as ``key(env, observation)`` if it takes two arguments, after each reset and after
each step, and returns anything that :func:`eigentrail.canonical` takes. ``env`` is the environment that was wrapped. A
key that is an object may have methods besides:

- ``reset(env)``, called after each reset, before the state is named;
- ``layout(env)``, called after it, which names the layout: each layout has a graph of its own;
- ``end(env)``, called in place of the key where an episode terminated: for worlds in which an episode can end where another
  one would go on;
- ``stop_clock(env)``, called before each step of :func:`eigentrail.explore`: what only depends on the time in the episode is then as
  at its beginning;
- ``timeless(env, reward)``, called by :func:`eigentrail.train` after each step: the reward without what only depends on the time in
  the episode.

It may also have an attribute ``reward_bound``: the most that the end of an episode can pay, for :func:`eigentrail.train`, which then looks for
nothing better.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from .names import canonical

KeyLike = str | Callable[..., Any]

_registry: dict[str, Callable[[], Any]] = {}


def register_key(name: str, key: Callable[..., Any]) -> None:
    """Gives a key a name, so that ``Shaped(env, key=name)`` can be written down in an environment's spec.

    A class is registered as what makes a key: each wrapper then has one of its own.

    >>> register_key("board", lambda env: env.unwrapped.board)
    """
    _registry[name] = key if inspect.isclass(key) else lambda: key


class Namer:
    """A key as the wrappers use it: it gives bytes, and knows the layout."""

    def __init__(self, key: KeyLike) -> None:
        self._key = _resolved(key)
        self._takes_observation = _takes_two(self._key)
        self._reset = getattr(self._key, "reset", None)
        self._layout = getattr(self._key, "layout", None)
        self._stop_clock = getattr(self._key, "stop_clock", None)
        self._end = getattr(self._key, "end", None)
        self._timeless = getattr(self._key, "timeless", None)

    def reset(self, env: Any) -> bytes | None:
        """To be called after each reset: the name of the layout, if the key knows layouts."""
        if self._reset is not None:
            self._reset(env)
        return None if self._layout is None else canonical(self._layout(env))

    @property
    def reward_bound(self) -> float | None:
        """The most that the end of an episode can pay, if the key knows it."""
        return getattr(self._key, "reward_bound", None)

    @property
    def knows_clock(self) -> bool:
        """Whether rewards depend on the time in the episode, which is no part of the state."""
        return self._stop_clock is not None

    def stop_clock(self, env: Any) -> None:
        """To be called before a step whose outcome is not to depend on the time."""
        if self._stop_clock is not None:
            self._stop_clock(env)

    def timeless(self, env: Any, reward: float) -> float:
        """The reward of the step before, without what depends on the time."""
        return reward if self._timeless is None else self._timeless(env, reward)

    def state(self, env: Any, observation: Any, terminated: bool = False) -> Any:
        """The present state, as the key gives it."""
        if terminated and self._end is not None:
            return self._end(env)
        return self._key(env, observation) if self._takes_observation else self._key(env)

    def __call__(self, env: Any, observation: Any, terminated: bool = False) -> bytes:
        """The name of the present state."""
        return canonical(self.state(env, observation, terminated))

    @property
    def needs_env(self) -> bool:
        """Whether an observation is not enough."""
        return self._key is not observation_key


def observation_key(env: Any, observation: Any) -> Any:
    """The observation itself."""
    return observation


class MiniGridPose:
    """Where the agent of a MiniGrid world stands and which way it looks.

    Doors and things do not count: a world where they matter has states that this key confuses.
    """

    reward_bound = 1.0

    def reset(self, env: Any) -> None:
        if not hasattr(env.unwrapped, "agent_dir"):
            raise TypeError(f'the keys "minigrid" and "minigrid-pose" name states of MiniGrid worlds, not of {env}')

    def layout(self, env: Any) -> Any:
        """The grid as it is at the beginning of an episode, and the mission."""
        world = env.unwrapped
        return (world.width, world.height, str(getattr(world, "mission", "")), _cells(world.grid))

    def stop_clock(self, env: Any) -> None:
        """Rewards of MiniGrid fall with the time."""
        env.unwrapped.step_count = 0

    def timeless(self, env: Any, reward: float) -> float:
        """What a goal pays that is reached at once, for one that is reached at any time."""
        world = env.unwrapped
        return 1.0 if reward > 0 and reward == world._reward() else reward

    def __call__(self, env: Any) -> bytes:
        world = env.unwrapped
        x, y = world.agent_pos
        return b"%d %d %d" % (x, y, world.agent_dir)


class MiniGrid(MiniGridPose):
    """All that changes in a MiniGrid world: the agent's pose, what it carries, doors, and things that can be moved.

    Doors and things are looked up once an episode, so that a name costs about as much as reading their state.
    """

    def __init__(self) -> None:
        self._doors: list[Any] = []
        self._things: list[Any] = []
        self._boxes: list[tuple[Any, Any]] = []

    def reset(self, env: Any) -> None:
        super().reset(env)
        self._doors, self._things, self._boxes = [], [], []
        grid = env.unwrapped.grid
        for index, thing in enumerate(grid.grid):
            self._note(thing, (index % grid.width, index // grid.width))

    def _note(self, thing: Any, place: tuple[int, int]) -> None:
        while thing is not None:
            if thing.type == "door":
                self._doors.append(thing)
            elif thing.can_pickup():
                self._things.append(thing)
                if thing.type == "box":
                    self._boxes.append((thing, place))
            thing = thing.contains  # of a box, what comes out of it

    def __call__(self, env: Any) -> bytes:
        world = env.unwrapped
        name = [*world.agent_pos, world.agent_dir]
        for door in self._doors:
            name.append(2 * door.is_locked + door.is_open)
        carried = world.carrying
        for thing in self._things:
            if thing is carried:
                name.append(-1)
            elif thing.cur_pos is None:
                name.append(-2)  # where it was at the beginning
            else:
                x, y = thing.cur_pos
                name.append(int(x) << 16 | int(y))
        for box, place in self._boxes:
            x, y = place if box.cur_pos is None else box.cur_pos
            name.append(box is carried or world.grid.get(x, y) is box)
        return b"%d " * len(name) % tuple(name)


class TopoGym:
    """Cell and heading in a TopoGym world, tries at hidden doors, the season and how far it has come. Clowns do not count.

    Where an episode is over only the cell counts. It has a name of its own: a boat that hits the ice ends its episode where
    it was.

    These are attributes that TopoGym keeps to itself; the key follows them as of TopoGym 0.8.
    """

    def __init__(self) -> None:
        self._seen: Any = None
        self._name: Any = None

    def reset(self, env: Any) -> None:
        if not type(env.unwrapped).__module__.startswith("topogym"):
            raise TypeError(f'the key "topogym" names states of TopoGym worlds, not of {env}')

    def layout(self, env: Any) -> Any:
        layout = env.unwrapped.layout
        if layout is not self._seen:
            self._seen = layout
            self._name = canonical((layout.start, layout.goal, layout.cell_types))
        return self._name

    def __call__(self, env: Any) -> Any:
        world = env.unwrapped
        place = world._state
        name: tuple[Any, ...] = (place.cell, place.frame)
        if world._bumps:
            name += (tuple(sorted(world._bumps.items())),)
        if getattr(world, "season", None) is not None:
            name += (world.season, len(world._frozen) + len(world._melted))
        return name

    def end(self, env: Any) -> Any:
        return ("over", env.unwrapped._state.cell)


def _cells(grid: Any) -> bytes:
    """Every cell: kind, colour, state, and what is inside."""
    cells: list[tuple[Any, ...] | None] = []
    for thing in grid.grid:
        while thing is not None:
            cells.append((thing.type, thing.color, thing.encode()[2]))
            thing = thing.contains
        cells.append(None)
    return canonical(tuple(cells))


def _resolved(key: KeyLike) -> Any:
    if isinstance(key, str):
        if key not in _registry:
            known = ", ".join(f'"{name}"' for name in sorted(_registry))
            raise ValueError(
                f'no key is called "{key}": choose one of {known}, a function of the environment, or register_key first'
            )
        return _registry[key]()
    if not callable(key):
        raise TypeError(f"a key is a name or a function of the environment, not {type(key).__qualname__}")
    return key() if inspect.isclass(key) else key


def _takes_two(key: Callable[..., Any]) -> bool:
    try:
        parameters = inspect.signature(key).parameters.values()
    except (TypeError, ValueError):
        return False
    places = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)
    required = [p for p in parameters if p.kind in places and p.default is inspect.Parameter.empty]
    return len(required) >= 2


register_key("obs", observation_key)
register_key("minigrid", MiniGrid)
register_key("minigrid-pose", MiniGridPose)
register_key("topogym", TopoGym)
