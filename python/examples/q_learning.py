"""Tabular Q-learning on any Gymnasium world whose states can be named, with or without eigentrail, in one file.

    python python/examples/q_learning.py --env-id MiniGrid-DoorKey-5x5-v0 --key minigrid --total-timesteps 20000
    python python/examples/q_learning.py --env-id MiniGrid-DoorKey-5x5-v0 --key minigrid --no-shaped --track-dir runs

Tags are CleanRL's: `charts/episodic_return` (raw), `charts/episodic_length`, `charts/epsilon`, `charts/SPS`, `losses/td_loss`; and
`graph/nodes`, `phi/max`. They are printed, and go to TensorBoard with `--track-dir` where PyTorch is installed.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict

import eigentrail
import gymnasium as gym
import numpy as np


def parse_args(arguments: list[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    flag = argparse.BooleanOptionalAction
    parser.add_argument("--env-id", default="CliffWalking-v1", help="the id of the environment")
    parser.add_argument("--key", default="obs", help='how states are named: "obs", "minigrid", …')
    parser.add_argument("--layout", type=int, default=0, help="the seed of a MiniGrid world's layout, the same in all episodes")
    parser.add_argument("--seed", type=int, default=1, help="the seed of the experiment")
    parser.add_argument("--total-timesteps", type=int, default=10_000, help="steps of the experiment")
    parser.add_argument("--learning-rate", type=float, default=0.5, help="the learning rate")
    parser.add_argument("--gamma", type=float, default=0.99, help="the discount, of the learner and of the shaping")
    parser.add_argument("--epsilon", type=float, default=0.05, help="the share of random actions")
    parser.add_argument("--shaped", action=flag, default=True, help="learn from the shaped reward")
    parser.add_argument("--advised", action=flag, default=True, help="add advice to Q when choosing")
    parser.add_argument("--track-dir", help="where TensorBoard files go")
    return parser.parse_args(arguments)


def make_env(args: argparse.Namespace) -> gym.Env:
    if args.env_id.startswith("MiniGrid"):
        from minigrid.wrappers import ReseedWrapper

        env = ReseedWrapper(gym.make(args.env_id), seeds=(args.layout,))
    else:
        env = gym.make(args.env_id)
    env = gym.wrappers.RecordEpisodeStatistics(env)  # inside: its returns are raw
    reward = "shaped" if args.shaped else "raw"
    return eigentrail.Shaped(env, key=args.key, gamma=args.gamma, seed=args.seed, reward=reward)


def main(arguments: list[str] | None = None) -> list[float]:
    args = parse_args(arguments)
    run_name = f"{args.env_id}__q_learning__{args.seed}__{int(time.time())}"
    writer = None
    if args.track_dir:
        from torch.utils.tensorboard import SummaryWriter

        writer = SummaryWriter(f"{args.track_dir}/{run_name}")
    rng = np.random.default_rng(args.seed)
    env = make_env(args)
    q = defaultdict(lambda: np.zeros(env.action_space.n))

    def log(tag: str, value: float, step: int) -> None:
        if writer is not None:
            writer.add_scalar(tag, value, step)

    returns: list[float] = []
    start_time = time.time()
    obs, info = env.reset(seed=args.seed)
    state = info["node"]  # the number of the state, by its key
    for global_step in range(1, args.total_timesteps + 1):
        # Act: advice is for choosing alone.
        values = q[state] + info["advice"] if args.advised else q[state]
        if rng.random() < args.epsilon:
            action = int(rng.integers(env.action_space.n))
        else:
            action = int(rng.choice(np.flatnonzero(values == values.max())))
        obs, reward, terminated, truncated, info = env.step(action)
        next_state = info["node"]

        # Learn: a state that was cut off has a value, one that ended the task has none.
        target = reward + (0.0 if terminated else args.gamma * q[next_state].max())
        td_error = target - q[state][action]
        q[state][action] += args.learning_rate * td_error
        state = next_state

        if terminated or truncated:
            episode = info["episode"]
            returns.append(float(episode["r"]))
            log("charts/episodic_return", returns[-1], global_step)
            log("charts/episodic_length", episode["l"], global_step)
            log("charts/epsilon", args.epsilon, global_step)
            log("charts/SPS", global_step / (time.time() - start_time), global_step)
            log("losses/td_loss", td_error**2, global_step)
            log("graph/nodes", info["graph_nodes"], global_step)
            log("phi/max", env.engine.potential().max(), global_step)
            print(f"global_step={global_step}, episodic_return={returns[-1]:.3f}, episodic_length={episode['l']}")
            obs, info = env.reset()
            state = info["node"]
    env.close()
    if writer is not None:
        writer.close()
    return returns


if __name__ == "__main__":
    main()
