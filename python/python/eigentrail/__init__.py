"""eigentrail turns the graph an agent is still discovering into a reward it can follow.

========================================  =====================================================================
``Shaped(env, key, gamma)``               a Gymnasium environment with shaped rewards and advice
``ShapedVec(envs, key, gamma)``           the same for vector environments: many walkers on one world model
``Engine(num_actions, gamma)``            the world model behind them, for loops of your own
``train(env, key)``                       the built-in agent on a Gymnasium environment
``explore(env, key)``                     the exact MDP of an environment: V*, Q*, an optimal policy
``check_shaping(mdp, phi, gamma)``        whether a shaping keeps the optimal actions, state by state
``run``, ``compare``, ``sweep``           scenarios, as the program runs them; ``ray.sweep`` on a cluster
``EigenTracker(k)``, ``track(graph, k)``  the lowest eigenvectors of a growing graph, kept up to date
``canonical(key)``                        names of states as unambiguous bytes
========================================  =====================================================================

Only NumPy is needed. ``Shaped`` and ``ShapedVec`` need Gymnasium: ``pip install eigentrail[gymnasium]``.
"""

from __future__ import annotations

import os
from importlib.metadata import version as _version
from typing import TYPE_CHECKING, Any

from . import _eigentrail
from .documents import Comparison, Run, Sweep
from .engine import Engine, Observed, Transitions
from .experiments import compare, run, sweep
from .keys import register_key
from .mdp import Mdp, ShapingCheck, Solution, check_shaping, explore
from .names import canonical
from .spectrum import EigenTracker, Tracked, track
from .training import Result, train

if TYPE_CHECKING:
    from .shaped import Shaped
    from .vector import ShapedVec

__version__ = _version("eigentrail")

__all__ = [
    "Comparison",
    "EigenTracker",
    "Engine",
    "Mdp",
    "Observed",
    "Result",
    "Run",
    "Shaped",
    "ShapedVec",
    "ShapingCheck",
    "Solution",
    "Sweep",
    "Tracked",
    "Transitions",
    "canonical",
    "check_shaping",
    "compare",
    "explore",
    "register_key",
    "run",
    "sweep",
    "track",
    "train",
]

if hasattr(os, "register_at_fork"):
    # A forked process does not have the threads of its parent: it starts its own.
    os.register_at_fork(after_in_child=_eigentrail.after_fork)


def __getattr__(name: str) -> Any:
    if name == "ray":
        import importlib

        return importlib.import_module(".ray", __name__)
    # Gymnasium is asked for by those who wrap environments only.
    try:
        if name == "Shaped":
            from .shaped import Shaped

            return Shaped
        if name == "ShapedVec":
            from .vector import ShapedVec

            return ShapedVec
    except ModuleNotFoundError as error:
        if error.name == "gymnasium":
            raise ImportError(
                f"eigentrail.{name} needs Gymnasium: pip install eigentrail[gymnasium]"
            ) from error
        raise
    raise AttributeError(f"module 'eigentrail' has no attribute {name!r}")
