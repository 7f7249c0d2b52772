"""Stable-Baselines3: many walkers on one world model, advice for its policies, and the graph in its logger.

>>> import gymnasium
>>> from stable_baselines3 import PPO
>>> from stable_baselines3.common.env_util import make_vec_env
>>> from eigentrail.sb3 import GraphCallback, ShapedVecEnv
>>> venv = ShapedVecEnv(make_vec_env("FrozenLake-v1", n_envs=4), key="obs", gamma=0.99)
>>> model = PPO("MlpPolicy", venv, gamma=0.99, n_steps=64, device="cpu").learn(256, callback=GraphCallback())
>>> venv.engine.num_walkers, venv.engine.steps
(4, 256)

A model that is to be led by advice as well, which is what finds the first goal:

>>> from eigentrail.sb3 import AdvisedPolicy
>>> venv = ShapedVecEnv(make_vec_env("FrozenLake-v1", n_envs=4), key="obs", gamma=0.99, advice=True)
>>> model = PPO(AdvisedPolicy, venv, gamma=0.99, n_steps=64, device="cpu").learn(256)
"""

from __future__ import annotations

try:
    import stable_baselines3 as _  # noqa: F401
except ModuleNotFoundError as error:
    if error.name != "stable_baselines3":
        raise
    raise ImportError("eigentrail.sb3 needs Stable-Baselines3: pip install eigentrail[sb3]") from error

from .advice import AdvisedPolicy
from .callback import GraphCallback
from .vec_env import ShapedVecEnv

__all__ = ["AdvisedPolicy", "GraphCallback", "ShapedVecEnv"]
