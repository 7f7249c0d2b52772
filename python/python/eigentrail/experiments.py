"""Scenarios from Python: what ``eigentrail run``, ``compare`` and ``sweep`` do, without a command line.

A scenario is a file, or the name of one that comes with eigentrail. ``out`` is a folder as the program writes it; one that has the
same in it already is gone on with, and what is finished there is not run again. Without it nothing is left on disk. All results are
those of the program, whatever the number of ``threads``.

Ctrl-C ends a call within about a second; seeds and trials that had ended by then are in ``out``. Progress is shown if tqdm is installed and
stderr is a terminal; ``progress=False`` silences it, ``progress=True`` shows it anywhere.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from numbers import Integral
from typing import Any

from . import _eigentrail
from .documents import Comparison, Run, Sweep
from .progress import Progress

Path = str | os.PathLike[str]
Settings = Mapping[str, Any]
Grid = Mapping[str, Iterable[Any]]
Seeds = Iterable[int]


def run(
    scenario: Path,
    seeds: int | Seeds | None = None,
    *,
    set: Settings | None = None,
    out: Path | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> Run:
    """Runs a scenario. The document is that of ``run --json``: for one seed, by default the scenario's own, its numbers; for several
    of them ``{"scenario", "seeds": [...]}``.

    >>> import eigentrail
    >>> result = eigentrail.run("smoke", seeds=3, set={"run.episodes": 30})
    >>> result["seed"], result["episodes"], result["first_goal_step"] is not None
    (3, 30, True)
    >>> [seed["seed"] for seed in eigentrail.run("smoke", seeds=range(2), set={"run.episodes": 30})["seeds"]]
    [0, 1]
    """
    alone = seeds is None or isinstance(seeds, Integral)
    listed = [] if seeds is None else [seeds] if isinstance(seeds, Integral) else distinct(seeds, "seeds")
    with Progress(progress, "episodes") as shown:
        document = _eigentrail.run(
            os.fspath(scenario), assignments(set), listed, alone, folder(out), ["eigentrail.run"], threads, shown.told
        )
    return Run(json.loads(document))


def compare(
    scenario: Path,
    arms: Iterable[str] = ("sparse", "gcn", "heat", "planner"),
    seeds: Seeds = range(20),
    *,
    set: Settings | None = None,
    tuned: bool = False,
    out: Path | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> Comparison:
    """Compares arms of a scenario over the same seeds. The document is that of ``compare --json``.

    >>> import eigentrail
    >>> result = eigentrail.compare("smoke", arms=["sparse", "gcn"], seeds=range(3), set={"run.episodes": 30})
    >>> [arm["name"] for arm in result["arms"]]
    ['sparse', 'gcn']
    """
    with Progress(progress, "trials") as shown:
        document = _eigentrail.compare(
            os.fspath(scenario),
            assignments(set),
            distinct([arms] if isinstance(arms, str) else arms, "arms"),
            distinct(seeds, "seeds"),
            tuned,
            folder(out),
            ["eigentrail.compare"],
            threads,
            shown.told,
        )
    return Comparison(json.loads(document))


def sweep(
    scenario: Path,
    grid: Grid | None = None,
    seeds: Seeds = range(20),
    *,
    arms: Iterable[str] = (),
    set: Settings | None = None,
    out: Path | None = None,
    threads: int | None = None,
    progress: bool | None = None,
) -> Sweep:
    """Runs every combination of the values of a grid over the same seeds. The document is that of ``sweep --json``;
    ``arms`` are laid over every point, if there are any.

    >>> import eigentrail
    >>> result = eigentrail.sweep("smoke", {"shaping.potential": ["gcn", "heat"]}, seeds=range(2), set={"run.episodes": 30})
    >>> [point["settings"][0]["value"] for point in result["points"]]
    ['gcn', 'heat']
    >>> [(trial["shaping.potential"], trial["seed"]) for trial in result.trials]
    [('gcn', 0), ('gcn', 1), ('heat', 0), ('heat', 1)]
    """
    with Progress(progress, "trials") as shown:
        document, trials = _eigentrail.sweep(
            os.fspath(scenario),
            assignments(set),
            axes(grid),
            distinct([arms] if isinstance(arms, str) else arms, None),
            distinct(seeds, "seeds"),
            folder(out),
            ["eigentrail.sweep"],
            threads,
            shown.told,
        )
    return Sweep(json.loads(document), trials)


def folder(out: Path | None) -> str | None:
    return None if out is None else os.fspath(out)


def distinct(values: Iterable[Any], name: str | None) -> list[Any]:
    """The values in their order, each once; under a name there must be one."""
    unique = list(dict.fromkeys(values))
    if name and not unique:
        raise ValueError(f"{name}: there are none")
    return unique


def assignments(settings: Settings | None) -> list[str]:
    """``section.key=value`` for each, as ``--set`` takes it."""
    return [f"{key}={toml(value)}" for key, value in (settings or {}).items()]


def axes(grid: Grid | None) -> list[tuple[str, list[str]]]:
    """Keys and the texts of their values, as ``--grid`` takes them."""
    listed = []
    for key, values in (grid or {}).items():
        if isinstance(values, str):
            raise TypeError(f"grid[{key!r}]: expected a list of values, and got the text {values!r}")
        listed.append((key, distinct([toml(value) for value in values], f"grid[{key!r}]")))
    return listed


def toml(value: Any) -> str:
    """A value as TOML writes it; NumPy's numbers and arrays too.

    >>> toml({"at": [3, 4.5], "name": "top-left"})
    '{ "at" = [3, 4.5], "name" = "top-left" }'
    """
    if hasattr(value, "tolist"):
        return toml(value.tolist())
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{toml(str(key))} = {toml(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, os.PathLike):
        return toml(os.fspath(value))
    if isinstance(value, Iterable):
        return "[" + ", ".join(toml(inner) for inner in value) + "]"
    raise TypeError(f"{value!r}: a scenario has no values of the type {type(value).__name__}")
