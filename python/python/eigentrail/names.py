"""Names of states as bytes: equal states, equal bytes, on every machine and in every process."""

from __future__ import annotations

import dataclasses
import enum
import struct
from collections.abc import Mapping
from typing import Any

import numpy as np

_LENGTH = struct.Struct(">I").pack
_FLOAT = struct.Struct(">d").pack
_COMPLEX = struct.Struct(">dd").pack


def canonical(key: Any) -> bytes:
    """The name of a state as bytes that no other state has.

    Takes ``None``, numbers, strings, bytes, enumerations, NumPy arrays and scalars, dataclasses, and tuples, lists,
    sets and dictionaries of these, nested as you like. Every value is written with its kind and its length, so that
    values that differ get bytes that differ: ``1``, ``"1"``, ``True`` and ``(1,)`` are four names. The order of sets
    and dictionaries does not count. NumPy's scalars are the numbers that they stand for; ``-0.0`` is ``0.0``.
    Python's ``hash()``, which changes from process to process and can collide, has no part in it.

    >>> canonical((3, "door")) == canonical((3, "door"))
    True
    >>> canonical((1, 23)) == canonical((12, 3))
    False
    >>> canonical(1).hex()
    '690000000101'
    """
    kind = type(key)
    if kind is bytes:
        return b"b" + _LENGTH(len(key)) + key
    if kind is int:
        return _integer(key)
    if kind is tuple:
        return b"(" + _LENGTH(len(key)) + b"".join(map(canonical, key))
    return _other(key)


def _integer(number: int) -> bytes:
    size = (number.bit_length() + 8) // 8
    return b"i" + _LENGTH(size) + number.to_bytes(size, "big", signed=True)


def _other(key: Any) -> bytes:
    if key is None:
        return b"N"
    if isinstance(key, enum.Enum):
        return b"e" + canonical((type(key).__module__, type(key).__qualname__, key.name))
    if isinstance(key, np.ndarray):
        return _array(key)
    if isinstance(key, (bool, np.bool_)):
        return b"T" if key else b"F"
    if isinstance(key, (int, np.integer)):
        return _integer(int(key))
    if isinstance(key, (float, np.floating)):
        return _number(float(key))
    if isinstance(key, (complex, np.complexfloating)):
        number = complex(key)
        return b"c" + _COMPLEX(number.real + 0.0, number.imag + 0.0)
    if isinstance(key, str):
        text = key.encode("utf-8", "surrogatepass")
        return b"s" + _LENGTH(len(text)) + text
    if isinstance(key, (bytes, bytearray, memoryview)):
        return canonical(bytes(key))
    if isinstance(key, tuple):
        return canonical(tuple(key))
    if isinstance(key, list):
        return b"[" + _LENGTH(len(key)) + b"".join(map(canonical, key))
    if isinstance(key, (set, frozenset)):
        return b"<" + _LENGTH(len(key)) + b"".join(sorted(map(canonical, key)))
    if isinstance(key, Mapping):
        items = sorted(canonical(name) + canonical(value) for name, value in key.items())
        return b"{" + _LENGTH(len(items)) + b"".join(items)
    if dataclasses.is_dataclass(key) and not isinstance(key, type):
        fields = tuple((f.name, getattr(key, f.name)) for f in dataclasses.fields(key) if f.compare)
        return b"d" + canonical((type(key).__module__, type(key).__qualname__, fields))
    raise TypeError(
        f"a state cannot be named by a value of type {type(key).__qualname__}: make the key of numbers, strings, "
        "bytes, NumPy arrays, dataclasses, and tuples, lists, sets or dictionaries of these"
    )


def _number(number: float) -> bytes:
    if number != number:
        number = float("nan")  # of all its bit patterns, one
    return b"f" + _FLOAT(number + 0.0)


def _array(array: np.ndarray) -> bytes:
    if array.dtype.kind not in "biufcSUmM":
        return b"o" + canonical((array.shape, array.ravel().tolist()))
    values = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
    if values.dtype.kind in "fc":
        values = values + values.dtype.type(0)  # -0.0 is 0.0
        if np.isnan(values).any():
            values[np.isnan(values)] = np.nan
    return b"a" + canonical((values.dtype.str, array.shape, values.tobytes()))
