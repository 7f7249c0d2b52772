"""MiniGrid with layouts that stay: steps to the first success, success at the end, and the length of the shortest way.

    benches/boards/run_minigrid.py OUT

Layout and agent have the same seed, ten of them. Views are not drawn: the key names states by what the world is.
"""

import eigentrail
import gymnasium
import minigrid  # noqa: F401 (registers its worlds)
import numpy as np
from minigrid.wrappers import ReseedWrapper
from results import Rows, arguments

# Steps of training, and whether the world is small enough to be explored to the end.
WORLDS = {
    "MiniGrid-Empty-8x8-v0": (20_000, True),
    "MiniGrid-FourRooms-v0": (40_000, True),
    "MiniGrid-LavaGapS7-v0": (20_000, True),
    "MiniGrid-DistShift1-v0": (20_000, True),
    "MiniGrid-DoorKey-5x5-v0": (30_000, True),
    "MiniGrid-DoorKey-8x8-v0": (100_000, False),
    "MiniGrid-MultiRoom-N4-S5-v0": (100_000, False),
    "MiniGrid-MultiRoom-N6-v0": (200_000, False),
    "MiniGrid-KeyCorridorS3R3-v0": (400_000, False),
}
COLUMNS = ["world", "seed", "steps", "first_success", "success", "length", "optimal", "greedy", "states"]


def world(name, seed):
    env = gymnasium.make(name, disable_env_checker=True)
    env.unwrapped.gen_obs = lambda: {}
    return ReseedWrapper(env, seeds=(seed,))


def shortest(name, seed):
    """Steps of the shortest way from the start, from the exact MDP; with a discount, since rewards are without the clock there."""
    mdp = eigentrail.explore(world(name, seed), key="minigrid", max_steps=3_000_000)
    gamma = 0.999
    best = mdp.solve(gamma=gamma).optimal_return
    reward = mdp.reward[mdp.ends].max()
    return round(1 + np.log(best / reward) / np.log(gamma))


def greedy(result, name, seed):
    """Steps to the goal of the policy as it was learnt; none if it does not get there."""
    env = world(name, seed)
    env.reset()
    namer = eigentrail.keys.Namer("minigrid")
    namer.reset(env)
    steps, over = 0, False
    while not over:
        action = result.policy(namer.state(env, None))
        if action is None:
            return None
        _, reward, terminated, truncated, _ = env.step(action)
        steps, over = steps + 1, terminated or truncated
    return steps if reward > 0 else None


def main():
    args = arguments(__doc__, seeds=(int, 10, "how many"))
    rows = Rows(args.out, "minigrid", COLUMNS, 2)
    for name, (max_steps, is_small) in WORLDS.items():
        for seed in range(args.seeds):
            if not rows.lacks(name, seed):
                continue
            result = eigentrail.train(world(name, seed), key="minigrid", max_steps=max_steps, seed=seed)
            episodes = result.episodes
            successes = episodes["return"] > 0
            first = int(episodes["end_step"][successes][0]) if successes.any() else None
            last = slice(-max(1, len(episodes) // 10), None)
            length = float(np.median(episodes["length"][last]))
            best = shortest(name, seed) if is_small else None
            success = round(float(successes[last].mean()), 4)
            rows.add(name, seed, max_steps, first, success, length, best, greedy(result, name, seed), result.nodes)


if __name__ == "__main__":
    main()
