"""The loosest and fastest settings with which a peer meets the common residual, found at 10 000 nodes and kept.

ARPACK's `tol` bounds ‖A⁻¹x − νx‖ relative to ν, which says little about ‖Lx − λx‖: so it is tried, with the size of the
Krylov space, and what passes at every third update of a sequence and takes least time is used at all sizes. PRIMME's and
lobpcg's tolerances are the residual itself.
"""

import itertools
import json
from pathlib import Path

import problem

GROWTH = 0.05
TIGHTER = 0.1


def candidates(peer: str, tau: float) -> list[dict]:
    if peer == "primme":
        methods = ("PRIMME_DEFAULT_MIN_MATVECS", "PRIMME_DEFAULT_MIN_TIME")
        axes = dict(block=(1, 4, 8), method=methods, tol=(1.0, 0.3))
    elif peer == "lobpcg-amg":
        axes = dict(maxiter=(40, 200), tol=(1.0, 0.3))
    elif tau >= 1e-3:
        axes = dict(ncv=(1.25, 1.5, 2.1), tol=(0.3, 0.1, 0.03, 0.01, 1e-3))
    else:
        axes = dict(ncv=(1.25, 1.5, 2.1), tol=(1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8))
    return [dict(zip(axes, choice)) for choice in itertools.product(*axes.values())]


def calibrated(store: Path, key: str, job: dict, run) -> dict:
    """The settings for `job["peer"]`, which `run` measures on the 10 000-node graph in `job["file"]`."""
    known = json.loads(store.read_text()) if store.exists() else {}
    if key not in known:
        n = problem.load(job["file"]).shape[0]
        sizes = sorted({*problem.sizes(n, GROWTH)[::3], n})
        known[key] = fastest(dict(job, sizes=sizes), run)
        store.write_text(json.dumps(known, indent=1))
    return known[key]


def fastest(job: dict, run) -> dict:
    trials = candidates(job["peer"], job["tau"])
    best, least = None, float("inf")
    for settings in trials:
        result = run(dict(job, settings=settings))
        if "failed" in result or any(u["residual"] > job["tau"] for u in result["updates"]):
            continue
        seconds = sum(u["cpu"] for u in result["updates"])
        if seconds < least:
            best, least = settings, seconds
    return best or min(trials, key=lambda settings: settings["tol"])


def tightened(settings: dict) -> dict:
    return dict(settings, tol=settings["tol"] * TIGHTER)
