"""Gymnasium's toy text: what the learnt policy earns, exactly, against the optimum of the environment's own table P.

    benches/boards/run_toy_text.py OUT

Both are returns without discount within the step limit of the environment (of the cliff, which has none: 1 000 steps).
"""

import eigentrail
import gymnasium
import numpy as np
from results import Rows, arguments

# Arguments of the environment, steps of training.
WORLDS = {
    "FrozenLake 4x4, not slippery": ("FrozenLake-v1", {"is_slippery": False}, 20_000),
    "FrozenLake 8x8, not slippery": ("FrozenLake8x8-v1", {"is_slippery": False}, 50_000),
    "FrozenLake 4x4": ("FrozenLake-v1", {}, 100_000),
    "FrozenLake 8x8": ("FrozenLake8x8-v1", {}, 300_000),
    "Taxi": ("Taxi-v4", {}, 100_000),
    "CliffWalking": ("CliffWalking-v1", {}, 20_000),
}
COLUMNS = ["world", "seed", "steps", "first_goal", "greedy", "optimum", "last_tenth"]


def value(env, choose):
    """The mean return of acting by `choose(state, what each action is worth)`, from the table, backwards from the step limit."""
    inner = env.unwrapped
    limit = env.spec.max_episode_steps or 1000
    outcomes = [(s, a, *outcome) for s, row in inner.P.items() for a, found in row.items() for outcome in found]
    state, action, chance, target, reward, end = (np.array(column) for column in zip(*outcomes, strict=True))
    shape = (inner.observation_space.n, inner.action_space.n)
    values = np.zeros(shape[0])
    for _ in range(limit):
        worth = np.zeros(shape)
        np.add.at(worth, (state, action), chance * (reward + np.where(end, 0.0, values[target.astype(int)])))
        values = choose(worth)
    return float(inner.initial_state_distrib @ values)


def main():
    args = arguments(__doc__, seeds=(int, 10, "how many"))
    rows = Rows(args.out, "toy_text", COLUMNS, 2)
    for name, (made_of, options, max_steps) in WORLDS.items():
        env = gymnasium.make(made_of, **options)
        optimum = value(env, lambda worth: worth.max(axis=1))
        for seed in range(args.seeds):
            if not rows.lacks(name, seed):
                continue
            result = eigentrail.train(env, key="obs", gamma=1.0, max_steps=max_steps, seed=seed)
            policy = np.array([result.policy(s) or 0 for s in range(env.observation_space.n)])
            greedy = value(env, lambda worth, policy=policy: worth[np.arange(len(policy)), policy])
            last = result.episodes["return"][-max(1, len(result.episodes) // 10):].mean()
            told = (round(number, 4) for number in (greedy, optimum, float(last)))
            rows.add(name, seed, max_steps, result.first_goal_step, *told)


if __name__ == "__main__":
    main()
