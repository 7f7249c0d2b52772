"""Long calls: a signal ends them, and other threads go on beside them."""

from __future__ import annotations

import signal
import sys
import threading
import time

import eigentrail
import numpy as np
import pytest
from conftest import Corridor

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals that a program sends itself")


class Interrupt:
    """Ctrl-C after so many seconds, and again each second: where Python ignores what is raised, as in a finaliser, one is lost."""

    def __init__(self, after: float) -> None:
        self.after = after

    def __enter__(self):
        self.before = signal.signal(signal.SIGALRM, signal.default_int_handler)
        self.begin = time.monotonic()
        signal.setitimer(signal.ITIMER_REAL, self.after, 1.0)
        return self

    def __exit__(self, *_):
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, self.before)
        self.seconds = time.monotonic() - self.begin


def ring(nodes: int):
    """A ring with a chord here and there, whose whole decomposition takes a second at a thousand nodes."""
    rng = np.random.default_rng(0)
    ends = np.concatenate([np.stack([np.arange(nodes), (np.arange(nodes) + 1) % nodes]), rng.integers(nodes, size=(2, nodes))], axis=1)
    dense = np.zeros((nodes, nodes), dtype=bool)
    dense[ends[0], ends[1]] = dense[ends[1], ends[0]] = True
    np.fill_diagonal(dense, False)
    offsets = np.concatenate([[0], dense.sum(axis=1).cumsum()])
    return offsets, np.nonzero(dense)[1], (nodes, nodes)


def test_an_update_ends_at_a_signal_and_leaves_the_tracker_as_it_was():
    small, large = ring(50), ring(1200)
    tracker = eigentrail.EigenTracker(4, method="full").update(small)
    values, vectors = tracker.eigenvalues.copy(), tracker.eigenvectors.copy()
    with Interrupt(0.1) as interrupt, pytest.raises(KeyboardInterrupt):
        tracker.update(large)
    begin = time.monotonic()
    expected = eigentrail.EigenTracker(4, method="full").update(large).eigenvalues
    whole = time.monotonic() - begin
    assert interrupt.seconds < whole / 2
    np.testing.assert_array_equal(tracker.eigenvalues, values)
    np.testing.assert_array_equal(tracker.eigenvectors, vectors)
    np.testing.assert_allclose(tracker.update(large).eigenvalues, expected, atol=1e-9)


def test_track_ends_at_a_signal():
    with Interrupt(0.1) as interrupt, pytest.raises(KeyboardInterrupt):
        eigentrail.track(ring(1200), 4, method="full", growth=0.5, start_nodes=1000)
    assert interrupt.seconds < 1.5


def test_a_refresh_ends_at_a_signal_and_leaves_the_engine_as_it_was():
    rare = {"growth": 1.0, "feature_growth": 1.0}
    engine = eigentrail.Engine(2, 1.0, spectral={"method": "full"}, schedule=rare)
    engine.begin_episode(b"0")
    for room in range(1, 1000):
        engine.observe(0, b"%d" % room, -1.0, False, False)
    before, values = engine.to_bytes(), engine.eigenvalues().copy()
    with Interrupt(0.1) as interrupt, pytest.raises(KeyboardInterrupt):
        engine.refit()
    assert engine.to_bytes() == before
    begin = time.monotonic()
    engine.refit()
    assert interrupt.seconds < (time.monotonic() - begin) / 2
    assert len(engine.eigenvectors()) == 1000 and not np.array_equal(engine.eigenvalues(), values)


@pytest.mark.parametrize("call", [eigentrail.train, eigentrail.explore])
def test_train_and_explore_end_at_a_signal(call):
    with Interrupt(0.1) as interrupt, pytest.raises(KeyboardInterrupt):
        call(Corridor(length=10**6, limit=10**9), max_steps=10**8)
    assert interrupt.seconds < 5


def test_other_threads_go_on_beside_an_update():
    counted = 0
    over = threading.Event()

    def count():
        nonlocal counted
        while not over.wait(0.005):
            counted += 1

    thread = threading.Thread(target=count)
    thread.start()
    begin = time.monotonic()
    eigentrail.EigenTracker(4, method="full").update(ring(800))
    seconds = time.monotonic() - begin
    over.set()
    thread.join()
    assert counted > seconds / 0.005 / 20
