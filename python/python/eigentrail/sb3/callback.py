"""The graph, its spectrum and the potential in the logger of a model."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnvWrapper

from ..engine import Engine
from .vec_env import ShapedVecEnv


class GraphCallback(BaseCallback):
    """Records, where the model's other figures go (TensorBoard, CSV, the terminal):

    ====================  ==================================================================
    ``graph/nodes``       states discovered
    ``graph/edges``       undirected edges between them
    ``graph/goals``       states that are believed to be goals
    ``graph/layouts``     layouts, each with a graph of its own; the other figures are of the latest
    ``pvf/eigenvalue_i``  the i-th lowest eigenvalue, from 0
    ``phi/min``, ``max``  range of the potential
    ``phi/shaping``       mean shaping a step since the last record
    ``phi/raw_reward``    mean reward of the environment a step since then
    ====================  ==================================================================

    Once a rollout, but not more often than every ``every`` steps of the model. You are warned if the model's discount
    is not that of the shaping, which would change what is optimal.
    """

    def __init__(self, every: int = 1000, verbose: int = 0) -> None:
        super().__init__(verbose)
        self._every = every
        self._next = 0
        self._sums = np.zeros(3)

    def _on_training_start(self) -> None:
        for gamma in sorted(set(self._found("gamma"))):
            model = getattr(self.model, "gamma", None)
            if model is not None and model != gamma:
                warnings.warn(
                    f"the model's gamma is {model} and that of the shaping {gamma}: what is optimal changes. "
                    "Give both the same",
                    UserWarning,
                    stacklevel=2,
                )

    def _on_step(self) -> bool:
        for info in self.locals.get("infos", ()):
            if "shaping" in info:
                self._sums += (1.0, info["shaping"], info["extrinsic_reward"])
        return True

    def _on_rollout_end(self) -> None:
        if self.num_timesteps < self._next:
            return
        self._next = self.num_timesteps + self._every
        engines: list[Engine] = list({id(engine): engine for engine in self._found("engine")}.values())
        layouts = {id(engine) for some in self._found("engines") for engine in some}
        if not engines:
            return
        for name, value in _figures(engines[-1]).items():
            self.logger.record(name, value)
        self.logger.record("graph/layouts", len(layouts))
        steps, shaping, raw = self._sums
        if steps:
            self.logger.record("phi/shaping", shaping / steps)
            self.logger.record("phi/raw_reward", raw / steps)
        self._sums = np.zeros(3)

    def _found(self, name: str) -> list[Any]:
        """An attribute of the vector wrapper, or of the wrappers of single environments."""
        venv = self.training_env
        while isinstance(venv, VecEnvWrapper):
            if isinstance(venv, ShapedVecEnv):
                return [getattr(venv, name)]
            venv = venv.venv
        try:
            return list(venv.get_attr(name))
        except AttributeError:
            raise ValueError(
                "GraphCallback found no eigentrail around the environment: use ShapedVecEnv, or Shaped in a DummyVecEnv"
            ) from None


def _figures(engine: Engine) -> dict[str, float]:
    potential = engine.potential()
    figures: dict[str, float] = {
        "graph/nodes": engine.num_nodes,
        "graph/edges": engine.num_edges,
        "graph/goals": len(engine.goals()),
        "phi/min": potential.min(initial=0.0),
        "phi/max": potential.max(initial=0.0),
    }
    for i, value in enumerate(engine.eigenvalues()):
        figures[f"pvf/eigenvalue_{i}"] = value
    return figures
