"""The engine driven from outside."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
import struct
import sys

import networkx as nx
import numpy as np
import pytest
from eigentrail import Engine, Observed, canonical

LENGTH = 12
FOLLOWED = {"exploration": {"potential_advice": 20.0}}


def play(engine: Engine, episodes: int, walker: int = 0, rng=None, limit: int = 60) -> list[Observed]:
    """A corridor: action 0 goes on, 1 back, 2 stays. Follows advice, or draws actions."""
    seen = []
    for _ in range(episodes):
        room, age = 0, 0
        engine.begin_episode(canonical(room), walker)
        while room < LENGTH - 1 and age < limit:
            action = int(engine.advice(walker).argmax()) if rng is None else int(rng.integers(3))
            room = max(0, room + (1, -1, 0)[action])
            age += 1
            over = room == LENGTH - 1
            seen.append(engine.observe(action, canonical(room), -1.0, over, not over and age == limit, walker))
    return seen


def test_the_potential_rises_towards_the_goal_and_is_the_way_that_is_left():
    engine = Engine(3, 1.0, **FOLLOWED)
    play(engine, 10)
    engine.refit()
    order = [engine.node_of(canonical(room)) for room in range(LENGTH)]
    # A soft value: somewhat below the return that is left.
    np.testing.assert_allclose(engine.potential()[order], np.arange(1 - LENGTH, 1), rtol=0.25)
    assert engine.goals() == [order[-1]] and engine.spurious_maxima() == []
    assert (engine.look_ahead()[order[:-1]].argmax(axis=1) == 0).all()
    assert engine.phi(canonical(3)) == engine.phi(order[3]) == engine.potential()[order[3]]


def test_shaping_telescopes_over_every_episode(rng):
    gamma = 0.9
    engine = Engine(3, gamma)
    for _ in range(30):
        start = canonical(0)
        before = engine.phi(start) if engine.num_nodes else 0.0
        seen = play(engine, 1, rng=rng)
        total = sum(gamma**t * step.shaping for t, step in enumerate(seen))
        assert total == pytest.approx(gamma ** len(seen) * seen[-1].phi - before, abs=1e-9)
    assert engine.goals(), "or it was all about zeros"


def test_the_first_goal_is_told_once(rng):
    seen = play(Engine(3, 1.0, **FOLLOWED), 5)
    assert [step.first_goal for step in seen].count(True) == 1
    first = next(step for step in seen if step.first_goal)
    assert first.node == LENGTH - 1 and first.new_node and first.phi == 0.0


def test_graphs_of_all_forms_are_what_was_seen(rng):
    engine = Engine(3, 1.0)
    counts: dict[tuple[int, int, int], int] = {}
    node = engine.begin_episode(b"0")
    for _ in range(500):
        action, room = int(rng.integers(3)), bytes([int(rng.integers(6))])
        seen = engine.observe(action, room, float(action), False, False)
        counts[node, action, seen.node] = counts.get((node, action, seen.node), 0) + 1
        node = seen.node
        assert engine.node() == node and engine.in_episode()
    graph = engine.graph()
    found = {tuple(way): count for *way, count in zip(*(c.tolist() for c in graph[:4]), strict=True)}
    assert found == counts
    np.testing.assert_array_equal(graph.reward, graph.action)
    matrix = engine.to_scipy()
    expected = np.zeros((engine.num_nodes, engine.num_nodes))
    for source, _, target in counts:
        if source != target:
            expected[source, target] = expected[target, source] = 1
    np.testing.assert_array_equal(matrix.toarray(), expected)
    assert matrix.nnz == 2 * engine.num_edges
    other = engine.to_networkx()
    assert isinstance(other, nx.MultiDiGraph)
    edges = {(u, d["action"], v): d["count"] for u, v, d in other.edges(data=True)}
    assert edges == counts
    assert [other.nodes[i]["key"] for i in range(engine.num_nodes)] == engine.keys()


def test_the_spectrum_is_that_of_the_graph(rng):
    engine = Engine(3, 1.0, spectral={"num_eigenpairs": 5, "tol": 1e-4})
    assert engine.eigenvalues().shape == (0,) and engine.eigenvectors().shape == (0, 0)
    play(engine, 20, rng=rng)
    engine.refresh()
    adjacency = engine.to_scipy().toarray()
    scale = 1 / np.sqrt(adjacency.sum(axis=1))
    laplacian = np.eye(len(scale)) - scale[:, None] * adjacency * scale
    np.testing.assert_allclose(engine.eigenvalues(), np.linalg.eigvalsh(laplacian)[:5], atol=1e-7)
    vectors = engine.eigenvectors()
    np.testing.assert_allclose(laplacian @ vectors, vectors * engine.eigenvalues(), atol=1e-3)


def test_arrays_are_read_only_snapshots(rng):
    engine = Engine(3, 1.0)
    play(engine, 3)
    for array in (engine.advice(), engine.potential(), engine.eigenvalues(), engine.graph().reward, engine.graph().count):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


def test_walkers_share_what_they_find():
    engine = Engine(3, 1.0, walkers=3, **FOLLOWED)
    play(engine, 4, walker=1)
    assert engine.node(0) == 0 and not engine.in_episode(0)
    steps = play(engine, 1, walker=2)
    assert len(steps) == LENGTH - 1, "the second walker knows the way that the first one found"
    with pytest.raises(IndexError, match="walker 3 of an engine with 3"):
        engine.begin_episode(b"x", walker=3)


def test_equal_runs_give_equal_bytes():
    engines = [Engine(3, 0.95, seed=seed, **FOLLOWED) for seed in (5, 5, 6)]
    seen = [play(engine, 12) for engine in engines]
    assert seen[0] == seen[1]
    assert engines[0].to_bytes() == engines[1].to_bytes() != engines[2].to_bytes()


@pytest.mark.parametrize(
    "copied",
    [copy.deepcopy, lambda engine: pickle.loads(pickle.dumps(engine)), lambda engine: Engine.from_bytes(engine.to_bytes())],
)
def test_a_copy_goes_on_as_if_nothing_had_happened(copied, rng):
    engine = Engine(3, 0.95, seed=3, **FOLLOWED)
    play(engine, 6)
    engine.begin_episode(canonical(0))
    engine.observe(0, canonical(1), -1.0, False, False)
    other = copied(engine)
    for one in (engine, other):
        one.observe(0, canonical(2), -1.0, False, False)
    assert play(engine, 5) == play(other, 5)
    assert engine.to_bytes() == other.to_bytes()


def played_on(engine: Engine) -> bytes:
    play(engine, 3)
    engine.refit()
    return engine.to_bytes()


@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="processes are not forked here")
@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
def test_forked_processes_go_on():
    """Though the threads that the fits of the parent started are not there."""
    engine = Engine(3, 1.0, **FOLLOWED)
    played_on(engine)
    saved = pickle.dumps(engine)
    with multiprocessing.get_context("fork").Pool(1) as pool:
        there = pool.apply_async(played_on, (pickle.loads(saved),)).get(timeout=300)
    assert there == played_on(engine)


def test_files_are_read_back_and_damage_is_found(tmp_path):
    engine = Engine(3, 1.0)
    play(engine, 3)
    path = tmp_path / "engine.bin"
    engine.save(path)
    saved = path.read_bytes()
    assert Engine.load(path).to_bytes() == saved and list(tmp_path.iterdir()) == [path]
    broken = {
        "too short for its header": saved[:10],
        "does not begin with EIGTRAIL": b"x" + saved[1:],
        "cut off or added to": saved[:-1],
        "the checksum of the payload does not match": saved[:-1] + bytes([saved[-1] ^ 1]),
        "written in version 9": saved[:12] + struct.pack("<I", 9) + saved[16:],
        "holds an object of kind TRCK, not ENGN": saved[:8] + b"TRCK" + saved[12:],
    }
    for told, content in broken.items():
        path.write_bytes(content)
        with pytest.raises(ValueError, match=told) as error:
            Engine.load(path)
        assert str(path) in str(error.value)


def test_what_is_out_of_range_is_refused_and_changes_nothing():
    engine = Engine(2, 1.0)
    with pytest.raises(RuntimeError, match="no episode is under way; call begin_episode after each reset"):
        engine.observe(0, b"a", 0.0, False, False)
    engine.begin_episode(b"a")
    for action in (2, -1, 70000):
        with pytest.raises(ValueError, match=f"action {action} of a world whose actions are 0..2"):
            engine.observe(action, b"b", 0.0, False, False)
    for reward in (float("nan"), float("inf")):
        with pytest.raises(ValueError, match="rewards must be finite"):
            engine.observe(0, b"b", reward, False, False)
    assert engine.num_nodes == 1 and engine.steps == 0
    with pytest.raises(IndexError, match="node 5 of a graph of 1"):
        engine.key_of(5)
    assert engine.node_of(b"b") is None


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"gamma": 1.5}, "agent.gamma = 1.5: must be"),
        ({"num_actions": 0}, "env.num_actions = 0: must be from 1 to 65536"),
        ({"walkers": 0}, "walkers = 0: must be at least 1"),
        ({"spectral": {"tol": 2.0}}, "spectral.tol = 2: must be"),
        ({"spectral": {"num_eigenpair": 3}}, "unknown field `num_eigenpair`, expected one of"),
        ({"spectrum": {}}, "unknown field `spectrum`, expected one of"),
        ({"shaping": {"potential": "oracle"}}, "needs a world that is known in full"),
        ({"exploration": {"kind": "curious"}}, "unknown variant `curious`"),
    ],
)
def test_parameters_are_checked_and_named(arguments, told):
    arguments = {"num_actions": 2, "gamma": 1.0, **arguments}
    with pytest.raises(ValueError, match=told):
        Engine(**arguments)


def test_parameters_are_those_of_a_scenario():
    engine = Engine(3, 1.0, shaping={"potential": "none"}, exploration={"kind": "count-bonus", "bonus": 2.0})
    seen = play(engine, 2, rng=np.random.default_rng(0))
    assert all(step.shaping == 0.0 for step in seen)
    assert seen[0].bonus > seen[-1].bonus > 0
    assert not engine.advice().any()


def test_a_name_of_two_states_is_found_out_and_slips_are_not(rng):
    """Rooms 0 to 5 around a hall that has one name, though what is behind it depends on the room one came from."""

    def walk(engine: Engine, next_room) -> tuple[int, int] | None:
        room = 0
        engine.begin_episode(b"room 0")
        for _ in range(3000):
            engine.observe(0, b"hall", 0.0, False, False)
            room = next_room(room)
            engine.observe(0, b"room %d" % room, 0.0, False, False)
        return engine.ambiguous

    confused = Engine(1, 1.0)
    assert walk(confused, lambda room: (room + 1) % 6) == (confused.node_of(b"hall"), 0)
    assert walk(Engine(1, 1.0), lambda room: int(rng.integers(6))) is None


def test_pytorch_geometric_is_asked_for_by_name(monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(ImportError, match=r"Engine.to_pyg needs torch: pip install eigentrail\[pyg\]"):
        Engine(2, 0.9).to_pyg()
