"""Results of scenarios: the documents that the program prints with ``--json``."""

from __future__ import annotations

import csv
import io
from typing import Any


class Document(dict[str, Any]):
    """A document as a dictionary, equal to what the program prints with ``--json`` (docs/json.md)."""

    def to_pandas(self) -> Any:
        """The rows of the document as a ``pandas.DataFrame``, inner fields by their names with dots."""
        return _frame(self._rows())

    def _rows(self) -> list[dict[str, Any]]:
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<eigentrail.{type(self).__name__}: {self['scenario']}, {len(self._rows())} rows>"


class Run(Document):
    """What came of :func:`eigentrail.run`. ``to_pandas()`` has a row for each seed."""

    def _rows(self) -> list[dict[str, Any]]:
        seeds: list[dict[str, Any]] = self.get("seeds", [self])
        return [dict(seed) for seed in seeds]


class Comparison(Document):
    """What came of :func:`eigentrail.compare`. ``to_pandas()`` has a row for each arm."""

    def _rows(self) -> list[dict[str, Any]]:
        return [dict(arm) for arm in self["arms"]]


class Sweep(Document):
    """What came of :func:`eigentrail.sweep`. ``to_pandas()`` has a row for each point, with the keys of the grid as columns;
    ``trials`` a dictionary for each point and seed, the rows of ``sweep.csv``."""

    def __init__(self, document: dict[str, Any], trials: str) -> None:
        super().__init__(document)
        self.trials: list[dict[str, Any]] = _trials(document, trials)

    def _rows(self) -> list[dict[str, Any]]:
        return [_spread(point) for point in self["points"]]

    def trials_to_pandas(self) -> Any:
        """The trials as a ``pandas.DataFrame``."""
        return _frame(self.trials)


def _spread(point: dict[str, Any]) -> dict[str, Any]:
    """A point with its settings as fields of their own, before the rest."""
    settings = {setting["key"]: setting["value"] for setting in point["settings"]}
    rest = {name: value for name, value in point.items() if name != "settings"}
    return settings | rest


def _trials(document: dict[str, Any], text: str) -> list[dict[str, Any]]:
    """The rows of ``sweep.csv``, all seeds of the first point before those of the next."""
    rows = list(csv.DictReader(io.StringIO(text)))
    places = [
        {name: point[name] for name in ("arm",) if name in point} | {s["key"]: s["value"] for s in point["settings"]}
        for point in document["points"]
    ]
    each = len(document["seeds"])
    return [
        {name: places[i // each][name] if name in places[i // each] else _value(cell) for name, cell in row.items()}
        for i, row in enumerate(rows)
    ]


def _value(cell: str) -> Any:
    """A number, a truth or nothing."""
    if cell in ("true", "false", ""):
        return {"true": True, "false": False, "": None}[cell]
    try:
        return int(cell)
    except ValueError:
        return float(cell)


def _frame(rows: list[dict[str, Any]]) -> Any:
    try:
        import pandas
    except ModuleNotFoundError as error:
        raise ImportError("to_pandas() needs pandas: pip install eigentrail[pandas]") from error
    return pandas.json_normalize(rows)
