"""What is compared with what, on which worlds, over which seeds: written down before it is run.

Seeds of three kinds, none of which has another use: those below 20 000 for building, from 20 000 for the tables, from 1 000 000 for
tuning. The worlds under HELD_OUT were run for the first time with the table: nothing was chosen by them.
"""

import itertools
from dataclasses import dataclass, field

FIRST_SEED = 20_000
FIRST_TUNING_SEED = 1_000_000
TUNING_SEEDS = 5


@dataclass(frozen=True)
class World:
    """A scenario, laid over with settings, and over how many seeds it is run."""

    name: str
    scenario: str
    seeds: int
    sets: tuple = ()


def world(scenario, seeds, name=None, sets=()):
    return World(name or scenario, scenario, seeds, tuple(sets))


# Goals at random places: the headline. 100 seeds up to a few hundred states, 30 up to a thousand, 10 beyond.
ANYWHERE = ("env.goals=random",)
RANDOM_GOALS = [
    world("four_rooms", 100, "four_rooms, goal anywhere", ANYWHERE),
    world("open_15x15", 100, "open_15x15, goal anywhere", ANYWHERE),
    world("u_trap", 100, "u_trap, goal anywhere", ANYWHERE),
    world("rooms_25x25", 30, "rooms_25x25, goal anywhere", ANYWHERE),
    world("rooms_50x50", 10, "rooms_50x50, goal anywhere", ANYWHERE),
    world("open_50x50", 10, "open_50x50, goal anywhere", ANYWHERE),
    world("maze_101", 10, "maze_101, goal anywhere", ANYWHERE),
]

# The same maps with the goals that they came with, in corners, where straight runs end: arms as they come only.
CORNERS = [
    world("four_rooms", 100),
    world("open_15x15", 100),
    world("u_trap", 100),
    world("rooms_25x25", 30),
    world("rooms_50x50", 10),
    world("open_50x50", 10),
    world("maze_101", 10),
]

# Ends that are no goals, actions that slip, a goal that moves, goals that pay, ways that cannot be gone back.
HARD = [
    world("lava_gap_7", 100),
    world("dist_shift_1", 100),
    world("dist_shift_2", 100),
    world("holes", 100),
    world("four_rooms_slip", 100),
    world("moving_goal", 30),
    world("rewarded_goals", 30),
    world("one_way", 100),
    world("open_15x15_turns", 30),
]

# Boards of the field, with their own rewards, ends and limits.
BOARDS = [
    world("cliff_walking", 100),
    world("frozen_lake_4", 100),
    world("frozen_lake_8", 10),
    world("taxi", 30),
    world("river_swim_6", 100),
    world("river_swim_20", 30),
    world("deep_sea_10", 30),
    world("deep_sea_stochastic_10", 30),
    world("bridge_pit", 30),
    world("bridge_swamp", 30),
    world("bridge_back", 30),
]

HELD_OUT = [
    world("rooms_25x25", 30, "rooms, doors and goal anywhere", ("env.doors=random", "env.seed=77", *ANYWHERE)),
    world("linked_grids", 100, "linked grids, goal anywhere", ANYWHERE),
    world("spiral", 100, "spiral, goal anywhere", ANYWHERE),
    world("maze_101", 30, "maze of 31 × 31, half of it loops, goal anywhere", ("env.rows=31", "env.cols=31", "env.loops=0.5", "env.seed=77", *ANYWHERE)),
    world("deep_sea_10", 30, "deep sea of 14, another map", ("env.size=14", "env.seed=77")),
    world("river_swim_6", 30, "river of 10", ("env.size=10", "env.max_steps=40")),
]

AS_THEY_COME = {"corners"}
# Arms that replay are tuned to ten to three hundred replays a step; these and planners take seconds to minutes a seed on ice. On these parts they
# run as they come.
SLOW_PARTS = {"boards", "held-out"}
SLOW = {"gcn", "no-shaping", "advice-only", "untrained", "heat", "hops", "dr", "sr", "planner", "planner-frontier"}
PARTS = {"random-goals": RANDOM_GOALS, "corners": CORNERS, "hard": HARD, "boards": BOARDS, "held-out": HELD_OUT}

# Where every arm chooses its settings; fewer episodes than in the table, so that all of it takes minutes.
TUNING_WORLDS = [
    world("four_rooms", TUNING_SEEDS, sets=("run.episodes=200", *ANYWHERE)),
    world("open_15x15", TUNING_SEEDS, sets=("run.episodes=50", *ANYWHERE)),
    world("cliff_walking", TUNING_SEEDS, sets=("run.episodes=300",)),
    world("frozen_lake_4", TUNING_SEEDS, sets=("run.episodes=1000",)),
    world("river_swim_6", TUNING_SEEDS, sets=("run.episodes=500",)),
    world("deep_sea_10", TUNING_SEEDS, sets=("run.episodes=1000",)),
    world("bridge_back", TUNING_SEEDS, sets=("run.episodes=500",)),
]


@dataclass(frozen=True)
class Axis:
    """A key and the values that may be tried, in order; those of `first` are tried first."""

    key: str
    values: tuple
    first: tuple


@dataclass(frozen=True)
class Arm:
    """An arm and what is tuned of it: nine pairs first, then, up to three times, the next value on each edge on which the best
    pair lies. The same for every arm."""

    name: str
    axes: tuple = field(default=())


CRITIC = Axis("agent.critic_learning_rate", (0.05, 0.1, 0.2, 0.4, 0.7, 1.0), (3, 4, 5))
ACTOR = Axis("agent.actor_learning_rate", (0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0), (2, 3, 4))
EPSILON = Axis("agent.epsilon", (0.0, 0.01, 0.05, 0.1, 0.2, 0.4), (0, 1, 2))
SCALE = Axis("shaping.scale_factor", (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0), (3, 4, 5))
ADVICE = Axis("exploration.potential_advice", (0.3, 1.0, 3.0, 10.0, 20.0, 40.0), (3, 4, 5))
FRONTIER = Axis("exploration.frontier_advice", (1.0, 3.0, 6.0, 12.0, 24.0, 48.0), (2, 3, 4))
TRIES = Axis("agent.known_after", (1, 2, 4, 8, 16, 32, 64), (0, 1, 2))
OPTIMISM = Axis("agent.initial_value", (0.0, 1.0, 10.0, 100.0), (0, 1, 2))
BACKUPS = Axis("agent.planning_steps", (1, 3, 10, 30, 100, 300), (1, 2, 3))
HORIZON = Axis("agent.horizon", (10, 30, 100, 300, 1000), (1, 2, 3))

ARMS = [
    Arm("sparse", (CRITIC, ACTOR)),
    Arm("count-bonus", (Axis("exploration.bonus", (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0), (2, 3, 4)), ACTOR)),
    Arm("gcn", (SCALE, BACKUPS)),
    Arm("no-shaping", (FRONTIER, BACKUPS)),
    Arm("advice-only", (BACKUPS, ADVICE)),
    Arm("untrained", (SCALE, BACKUPS)),
    Arm("heat", (SCALE, BACKUPS)),
    Arm("hops", (SCALE, BACKUPS)),
    Arm("dr", (SCALE, BACKUPS)),
    Arm("sr", (SCALE, BACKUPS)),
    Arm("look-ahead", (SCALE, ADVICE)),
    Arm("actor-critic-shaped", (SCALE, ACTOR)),
    Arm("actor-critic-unshaped", (FRONTIER, ACTOR)),
    Arm("q-learning", (CRITIC, EPSILON)),
    Arm("sarsa", (CRITIC, EPSILON)),
    Arm("dyna-q", (OPTIMISM, EPSILON)),
    Arm("dyna-q-plus", (Axis("agent.time_bonus", (1e-4, 1e-3, 1e-2, 0.1, 1.0), (1, 2, 3)), BACKUPS)),
    Arm("planner", (TRIES, Axis("agent.optimistic_value", (0.0, 1.0, 10.0, 100.0), (0, 1, 2)))),
    Arm("planner-frontier", (TRIES, FRONTIER)),
    Arm("mbie-eb", (Axis("agent.bonus", (0.01, 0.03, 0.1, 0.3, 1.0, 3.0), (2, 3, 4)), HORIZON)),
    Arm("ucbvi", (Axis("agent.bonus", (0.0005, 0.002, 0.0125, 0.05, 0.2), (1, 2, 3)), HORIZON)),
    Arm("psrl", (Axis("agent.prior_tries", (0.01, 0.03, 0.1, 0.3, 1.0, 3.0), (2, 3, 4)), HORIZON)),
]

# Not tuned: hostile and random potentials, the true distance, and the paper as it is printed.
FIXED = ["oracle", "random-potential", "negated-oracle", "report"]

# Arms that plan a whole episode ahead take hundreds of times the time a step beyond a hundred cells; of the rest, what worlds of
# thousands of states (a map of the same kind may be smaller, and has more seeds then) can do without.
EPISODE_PLANNERS = {"mbie-eb", "ucbvi", "psrl"}
CELLS = {"open_15x15", "u_trap", "rooms_25x25", "maze_101", "spiral", "one_way", "open_15x15_turns", "four_rooms_slip", "taxi"}
THOUSANDS = {"rooms_50x50", "open_50x50", "maze_101"}
SMALL_ONLY = EPISODE_PLANNERS | {"report", "negated-oracle", "random-potential", "sarsa", "count-bonus"}


def arms_on(world):
    """The names of the arms that are run on a world."""
    large = world.scenario in THOUSANDS and world.seeds <= 10
    left_out = SMALL_ONLY if large else EPISODE_PLANNERS if world.scenario in CELLS else set()
    return [name for name in [arm.name for arm in ARMS] + FIXED if name not in left_out]


# docs/method.md: what each part of the default arm does, and what the paper's recipe does.
METHOD_WORLDS = [
    world("four_rooms", 30, "four_rooms, goal anywhere", ANYWHERE),
    world("open_15x15", 30, "open_15x15, goal anywhere", ANYWHERE),
    world("rooms_25x25", 30, "rooms_25x25, goal anywhere", ANYWHERE),
    world("four_rooms", 30),
    world("rooms_25x25", 30),
]

# Without a search nothing but its own optimism leads the agent to what it has not tried.
NO_SEARCH = {"exploration.frontier_advice": 0, "agent.untried": "optimistic"}
NO_SHAPING = {"shaping.mix": 0}
ADVICE_TOO = {"exploration.potential_advice": 20}
UNTRAINED = {"shaping.cold_epochs": 0, "shaping.warm_epochs": 0}
NO_EXPLORATION = {"exploration.kind": "none"}

# Search × shaped reward × look-ahead advice × training. Where φ is used for nothing, training is nothing.
FACTORIAL = {
    f"search-{s}-shaping-{r}-advice-{a}-training-{t}": {
        **({} if s else NO_SEARCH),
        **({} if r else NO_SHAPING),
        **(ADVICE_TOO if a else {}),
        **({} if t else UNTRAINED),
    }
    for s, r, a, t in itertools.product((1, 0), repeat=4)
    if t or r or a
}

# The paper's learner, a plain actor-critic: they begin as the arm `gcn-shaping-only`.
RECIPES = {
    "as-printed": {"shaping.potential": "report", "shaping.scale": "raw", **NO_EXPLORATION},
    "printed-shifted": {"shaping.potential": "report", **NO_EXPLORATION},
    "printed-random-features": {"shaping.potential": "report", "gcn.features": "random", **NO_EXPLORATION},
    "printed-deepwalk": {"shaping.potential": "report", "gcn.features": "deepwalk", **NO_EXPLORATION},
    "gcn-alone": NO_EXPLORATION,
    "gcn-alone-hundredth-of-scale": {"shaping.scale_factor": 0.04, **NO_EXPLORATION},
    "gcn-alone-tenth-of-scale": {"shaping.scale_factor": 0.4, **NO_EXPLORATION},
    "gcn-alone-ten-times-scale": {"shaping.scale_factor": 40, **NO_EXPLORATION},
    "gcn-alone-random-features": {"gcn.features": "random", **NO_EXPLORATION},
    "gcn-alone-constant-feature": {"gcn.features": "constant", **NO_EXPLORATION},
    "gcn-alone-deepwalk": {"gcn.features": "deepwalk", **NO_EXPLORATION},
    "heat-alone": {"shaping.potential": "heat", **NO_EXPLORATION},
    "heat-alone-steep": {"shaping.potential": "heat", "shaping.heat_kept": 0.0434, **NO_EXPLORATION},
    "hops-alone": {"shaping.potential": "hops", **NO_EXPLORATION},
    "oracle-alone": {"shaping.potential": "oracle", **NO_EXPLORATION},
}

METHOD_ARMS = {**FACTORIAL, **RECIPES}

SENSITIVITY_ARMS = ["sparse", "gcn", "no-shaping", "look-ahead", "q-learning", "planner", "planner-frontier", "psrl"]
SENSITIVITY = [
    world(scenario, 30, f"{scenario}, {what}", sets)
    for scenario, variants in {
        "four_rooms": {
            "a fifth of the episodes": ("run.episodes=100", *ANYWHERE),
            "four times the episodes": ("run.episodes=2000", *ANYWHERE),
            "half the limit": ("env.max_steps=520", *ANYWHERE),
            "four times the limit": ("env.max_steps=4160", *ANYWHERE),
        },
        "frozen_lake_4": {
            "a fifth of the episodes": ("run.episodes=400",),
            "four times the episodes": ("run.episodes=8000",),
            "half the limit": ("env.max_steps=50",),
            "four times the limit": ("env.max_steps=400",),
        },
        "cliff_walking": {
            "a fifth of the episodes": ("run.episodes=100",),
            "four times the episodes": ("run.episodes=2000",),
        },
    }.items()
    for what, sets in variants.items()
]

# Time by the step, alone on the machine.
TIMES = [world(name, 5) for name in ("four_rooms", "open_15x15", "rooms_25x25", "rooms_50x50", "maze_101", "cliff_walking")]
TIMES_ARMS = ["sparse", "gcn", "heat", "look-ahead", "planner", "planner-frontier", "psrl"]
