"""Progress as tqdm draws it, or none."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any


class Progress:
    """A bar while the block goes on. ``told``, which takes what is done and what there is, is ``None`` if nothing is shown."""

    def __init__(self, shown: bool | None, unit: str) -> None:
        self._bar: Any = None
        self.told: Callable[[int, int], None] | None = None
        if shown is False or (shown is None and not (sys.stderr and sys.stderr.isatty())):
            return
        try:
            from tqdm import tqdm
        except ModuleNotFoundError as error:
            if shown:
                raise ImportError("progress=True needs tqdm: pip install tqdm") from error
            return
        self._bar = tqdm(unit=f" {unit}", leave=False)
        self.told = self._tell

    def _tell(self, done: int, total: int) -> None:
        if total:
            self._bar.total = total
        self._bar.n = done
        self._bar.refresh()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()
