"""Stable-Baselines3's PPO on MiniGrid worlds with a fixed layout: wrapped, unwrapped, and with a bonus for novelty.

    python python/benches/learning/ppo.py [--seeds 5] [--cap 100000] [--worlds DoorKey-8x8 …] [--arms …] [--json FILE]

Counted are environment steps of all walkers until the goal was first reached, and until it was reached in 18 of the last 20 episodes, exploration
included. Runs that do not come there end at the cap, and count as the cap. One thread of PyTorch. All arms have the
hyperparameters below, which were not tuned for any of them. docs/python.md has figures.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import warnings
from collections import Counter, deque
from pathlib import Path
from typing import Any

import gymnasium as gym
import minigrid  # noqa: F401 (registers its worlds)
import torch
from minigrid.wrappers import ImgObsWrapper, ReseedWrapper
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.env_util import make_vec_env

sys.path.insert(0, str(Path(__file__).parent))
from tabular import GAMMA, LAYOUT, WORLDS, told  # noqa: E402

from eigentrail.sb3 import AdvisedPolicy, ShapedVecEnv  # noqa: E402

ARMS = ("unwrapped", "count bonus", "wrapped", "wrapped, no advice", "advice alone")
WALKERS = 8
BONUS = 0.01
# SB3's defaults but for these: a tenth of entropy keeps it exploring, and short rollouts keep it learning.
PPO_SETTINGS: dict[str, Any] = {
    "n_steps": 128,
    "batch_size": 256,
    "n_epochs": 4,
    "learning_rate": 3e-4,
    "ent_coef": 0.01,
    "gamma": GAMMA,
    "gae_lambda": 0.95,
}


class Scaled(gym.ObservationWrapper):
    """MiniGrid's codes, at most 10, as numbers up to 1 in one row."""

    def __init__(self, env: gym.Env) -> None:
        super().__init__(env)
        size = int(torch.tensor(env.observation_space.shape).prod())
        self.observation_space = gym.spaces.Box(0.0, 1.0, (size,), "float32")

    def observation(self, observation: Any) -> Any:
        return observation.reshape(-1).astype("float32") / 10.0


class CountBonus(gym.Wrapper):
    """Adds weight ÷ √n for the n-th visit of a state, all walkers together; states are named as eigentrail does."""

    def __init__(self, env: gym.Env, counts: Counter[bytes], weight: float) -> None:
        super().__init__(env)
        from eigentrail.keys import Namer

        self.namer, self.counts, self.weight = Namer("minigrid"), counts, weight

    def reset(self, **arguments: Any) -> Any:
        result = self.env.reset(**arguments)
        self.namer.reset(self.env)
        return result

    def step(self, action: Any) -> Any:
        observation, reward, terminated, truncated, info = self.env.step(action)
        name = self.namer(self.env, observation)
        self.counts[name] += 1
        return observation, float(reward) + self.weight / self.counts[name] ** 0.5, terminated, truncated, info


class Counted(BaseCallback):
    """Watches for successes, and stops when there are enough."""

    def __init__(self) -> None:
        super().__init__()
        self.first: int | None = None
        self.often: int | None = None
        self.lately: deque[bool] = deque(maxlen=20)

    def _on_step(self) -> bool:
        for info in self.locals["infos"]:
            if "episode" in info:
                success = info["episode"]["r"] > 0
                if success and self.first is None:
                    self.first = self.num_timesteps
                self.lately.append(success)
                if sum(self.lately) >= 18 and self.often is None:
                    self.often = self.num_timesteps
        return self.often is None


def run(name: str, arm: str, seed: int, cap: int) -> tuple[int | None, int | None]:
    counts: Counter[bytes] = Counter()

    def wrapped(env: gym.Env) -> gym.Env:
        # make_vec_env has put a Monitor inside, which sees raw returns.
        env = CountBonus(env, counts, BONUS) if arm == "count bonus" else env
        return Scaled(ImgObsWrapper(env))

    def one() -> gym.Env:
        return ReseedWrapper(gym.make(name), seeds=(LAYOUT,))

    venv = make_vec_env(one, n_envs=WALKERS, seed=seed, wrapper_class=wrapped)
    policy: Any = "MlpPolicy"
    if arm not in ("unwrapped", "count bonus"):
        advised = arm in ("wrapped", "advice alone")
        kind = "raw" if arm == "advice alone" else "shaped"
        venv = ShapedVecEnv(venv, key="minigrid", gamma=GAMMA, seed=seed, reward=kind, advice=advised)
        policy = AdvisedPolicy if advised else policy
    model = PPO(policy, venv, seed=seed, device="cpu", **PPO_SETTINGS)
    watch = Counted()
    model.learn(cap, callback=watch)
    return watch.first, watch.often


def main() -> None:
    global BONUS
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--cap", type=int, default=100_000)
    parser.add_argument("--worlds", nargs="+", default=list(WORLDS), choices=list(WORLDS))
    parser.add_argument("--arms", nargs="+", default=list(ARMS), choices=list(ARMS))
    parser.add_argument("--bonus", type=float, default=BONUS)
    parser.add_argument("--json", type=Path)
    asked = parser.parse_args()
    BONUS = asked.bonus
    warnings.simplefilter("ignore")
    torch.set_num_threads(1)
    results = []
    for world in asked.worlds:
        for arm in asked.arms:
            begin = time.time()
            found = [run(WORLDS[world], arm, seed, asked.cap) for seed in range(asked.seeds)]
            first, often = zip(*found, strict=True)
            print(f"{world} | {arm} | {told(list(first), asked.cap)} | {told(list(often), asked.cap)}", flush=True)
            print(f"  {time.time() - begin:.0f} s", file=sys.stderr)
            results.append({"world": world, "arm": arm, "first": first, "often": often})
            if asked.json:
                asked.json.write_text(json.dumps({"cap": asked.cap, "results": results}, indent=1) + "\n")


if __name__ == "__main__":
    main()
