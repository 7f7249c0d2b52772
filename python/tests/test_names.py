"""Names of states: values that differ get bytes that differ, and equal ones equal bytes."""

from __future__ import annotations

import dataclasses
import enum
import os
import subprocess
import sys

import numpy as np
import pytest
from eigentrail import canonical


class Colour(enum.Enum):
    RED = 1
    BLUE = 2


@dataclasses.dataclass
class Pose:
    x: int
    y: int


@dataclasses.dataclass
class Place:
    x: int
    y: int


DIFFERENT = [
    None, True, False, 0, 1, -1, 127, 128, -128, -129, 255, 256, 2**64, -(2**64), 0.0, 1.0, 0.5, float("inf"), 1j, 1 + 0j,
    "", "1", "a", "ab", b"", b"1", b"a", (), (1,), (1, 2), (12,), ((1,), 2), (1, (2,)), ("a", "b"), ("ab",), ("a", "b", ""),
    [], [1], [1, 2], {1}, {1, 2}, {}, {1: 2}, {2: 1}, {"a": (1, 2)}, Colour.RED, Colour.BLUE, Pose(1, 2), Pose(2, 1), Place(1, 2),
    np.array([1, 2]), np.array([1, 2], dtype=np.int8), np.array([[1, 2]]), np.array([[1], [2]]), np.array([1.0, 2.0]),
    np.array(["a", "b"]), np.array([True, False]), np.array([], dtype=np.int64), np.zeros((0, 3), dtype=np.int64),
]  # fmt: skip


def test_values_that_differ_have_names_that_differ():
    names = [canonical(value) for value in DIFFERENT]
    assert len(set(names)) == len(DIFFERENT)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (1, np.int64(1)),
        (1, np.uint8(1)),
        (0.5, np.float32(0.5)),
        (0.0, -0.0),
        (True, np.bool_(True)),
        ("a", np.str_("a")),
        (b"a", bytearray(b"a")),
        (b"a", memoryview(b"a")),
        (float("nan"), -float("nan")),
        ({1, 2, 300}, {300, 2, 1}),
        ({"a": 1, "b": 2}, {"b": 2, "a": 1}),
        (np.arange(6).reshape(2, 3), np.asfortranarray(np.arange(6).reshape(2, 3))),
        (np.array([1, 2], dtype="<i4"), np.array([1, 2], dtype=">i4")),
        (np.array([0.0]), np.array([-0.0])),
        (np.arange(10)[::2], np.array([0, 2, 4, 6, 8])),
    ],
)
def test_values_that_are_equal_have_equal_names(one, other):
    assert canonical(one) == canonical(other)


def test_integers_of_any_size_are_told_apart(rng):
    integers = sorted({int(i) for i in rng.integers(-(2**40), 2**40, size=2000)} | set(range(-300, 300)))
    assert len({canonical(i) for i in integers}) == len(integers)


def test_names_do_not_depend_on_the_process():
    code = "from eigentrail import canonical; print(canonical(('door', frozenset({'a', 'b', 'c'}), 1.5)).hex())"
    told = set()
    for seed in ("1", "2", "3"):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        told.add(subprocess.run([sys.executable, "-c", code], env=environment, check=True, capture_output=True).stdout)
    assert len(told) == 1


def test_what_has_no_name_is_refused_with_advice():
    with pytest.raises(TypeError, match="a state cannot be named by a value of type object: make the key of numbers"):
        canonical((1, object()))
