"""A MiniGrid world with a fixed layout that answers from memory what it has been asked before: the same world, a hundred times as
fast. Observations are the numbers of its states, in order of discovery."""

from __future__ import annotations

from typing import Any

import eigentrail
import gymnasium as gym
import minigrid  # noqa: F401 (registers its worlds)
import numpy as np

State = tuple[Any, ...]


class Remembered(gym.Env):
    """Steps that were never taken are taken in MiniGrid, put into the state in question; the clock is kept here."""

    def __init__(self, name: str, layout: int) -> None:
        self.world = gym.make(name).unwrapped
        self.world.reset(seed=layout)
        self.action_space = self.world.action_space
        self.observation_space = gym.spaces.Discrete(1 << 20)
        self.limit = self.world.max_steps
        things = [thing for thing in self.world.grid.grid if thing is not None]
        self.doors = [thing for thing in things if thing.type == "door"]
        self.things = [thing for thing in things if thing.can_pickup()]
        if any(thing.type == "box" for thing in self.things):
            raise ValueError(f"{name}: boxes are not remembered")
        for index, thing in enumerate(self.world.grid.grid):
            if thing in self.things:
                thing.cur_pos = (index % self.world.width, index // self.world.width)
        self.states: list[State] = []
        self.numbers: dict[State, int] = {}
        self.answers: dict[tuple[int, int], tuple[int, bool, bool]] = {}
        self.start = self.number(self.state())

    def state(self) -> State:
        """Pose, doors, and where things are; `None` for what is carried."""
        world = self.world
        places = (None if thing is world.carrying else tuple(map(int, thing.cur_pos)) for thing in self.things)
        doors = ((door.is_open, door.is_locked) for door in self.doors)
        return (tuple(map(int, world.agent_pos)), int(world.agent_dir), tuple(doors), tuple(places))

    def number(self, state: State) -> int:
        if state not in self.numbers:
            self.numbers[state] = len(self.states)
            self.states.append(state)
        return self.numbers[state]

    def put(self, state: State) -> None:
        """Puts MiniGrid into a state."""
        world = self.world
        for thing in self.things:
            if thing is not world.carrying:
                world.grid.set(*thing.cur_pos, None)
        world.carrying = None
        place, world.agent_dir, doors, places = state
        world.agent_pos = np.array(place)
        for door, (door.is_open, door.is_locked) in zip(self.doors, doors, strict=True):
            pass
        for thing, where in zip(self.things, places, strict=True):
            if where is None:
                world.carrying = thing
                thing.cur_pos = np.array([-1, -1])
            else:
                world.grid.set(*where, thing)
                thing.cur_pos = np.array(where)
        world.step_count = 0

    def answer(self, here: int, action: int) -> tuple[int, bool, bool]:
        self.put(self.states[here])
        _, reward, terminated, _, _ = self.world.step(action)
        self.answers[here, action] = result = (self.number(self.state()), bool(reward > 0), bool(terminated))
        return result

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[int, dict[str, Any]]:
        super().reset(seed=seed)
        self.here, self.age = self.start, 0
        return self.here, {}

    def step(self, action: int) -> tuple[int, float, bool, bool, dict[str, Any]]:
        found = self.answers.get((self.here, action)) or self.answer(self.here, action)
        self.here, success, over = found
        self.age += 1
        reward = 1 - 0.9 * (self.age / self.limit) if success else 0.0
        return self.here, reward, over, self.age >= self.limit, {}


def compare(name: str, layout: int, steps: int = 3000, seed: int = 0) -> int:
    """Holds it against MiniGrid, step by step: names of states, rewards, ends. Half of the actions are random, half those that
    lead to what is new and to the goal. Returns how often the goal was reached."""
    ours, theirs = Remembered(name, layout), gym.make(name).unwrapped
    guide = eigentrail.Shaped(ours, key="obs", exploration={"potential_advice": 20.0}, reward="raw")
    namer, names = eigentrail.keys.Namer("minigrid"), {}
    rng = np.random.default_rng(seed)
    successes, fresh = 0, True
    for step in range(steps):
        if fresh:
            _, info = guide.reset()
            theirs.reset(seed=layout)
            namer.reset(theirs)
        guided = step // 500 % 2 == 0
        action = int(info["advice"].argmax() if guided else rng.integers(ours.action_space.n))
        _, reward, over, cut, info = guide.step(action)
        observation, expected, *ends, _ = theirs.step(action)
        assert (reward, [over, cut]) == (expected, ends), (reward, expected, over, cut, ends)
        name_there = namer(theirs, observation)
        assert names.setdefault(ours.here, name_there) == name_there
        successes += reward > 0
        fresh = over or cut
    assert len(set(names.values())) == len(names), "two of our states are one there"
    return successes
