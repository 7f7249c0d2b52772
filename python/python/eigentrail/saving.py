"""Wrappers in files: what they found out, and how they were made."""

from __future__ import annotations

import json
import os
from typing import Any, Self

from . import _eigentrail, files
from .keys import KeyLike
from .worlds import Worlds


class Saved:
    """A wrapper that can be written to a file. It is called with an environment and with its settings."""

    _settings: dict[str, Any]
    _worlds: Worlds

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes what was found out so far to a file with a version and a checksum: the engines of all layouts, and how the
        wrapper was made. Environments are no part of it. The file is there in full or as it was before."""
        key = self._settings["key"]
        settings = json.dumps({**self._settings, "key": key if isinstance(key, str) else None})
        engines = [(layout, engine.to_bytes()) for layout, engine in self._worlds.engines.items()]
        files.write(path, _eigentrail.pack_worlds(settings, engines))

    @classmethod
    def load(cls, path: str | os.PathLike[str], env: Any, key: KeyLike | None = None) -> Self:
        """The wrapper in a file, around an environment; ``reset`` comes next. A key that is a function is in no file and has to be
        given again."""
        written, engines = files.read(path, _eigentrail.unpack_worlds)
        settings = json.loads(written)
        if key is not None:
            settings["key"] = key
        if settings["key"] is None:
            raise ValueError(f"{os.fspath(path)}: states were named by a function, which no file holds: give it as key")
        wrapper = cls(env, **settings)  # type: ignore[call-arg]
        try:
            wrapper._worlds.take_up(engines)
        except ValueError as error:
            raise ValueError(f"{os.fspath(path)}: {error}") from error
        return wrapper
