"""The engine's graph in PyTorch Geometric."""

from __future__ import annotations

import sys

import eigentrail
import numpy as np
import pytest
from torch_geometric.utils import to_scipy_sparse_matrix


def explored() -> eigentrail.Engine:
    engine = eigentrail.Engine(2, 0.9)
    for _ in range(3):
        engine.begin_episode(b"0")
        for room in range(1, 9):
            engine.observe(0, b"%d" % room, -1.0, room == 8, False)
    return engine


def test_it_has_every_transition_and_what_is_known_of_states():
    engine = explored()
    engine.begin_episode(b"another")
    data = engine.to_pyg()
    graph = engine.graph()
    assert data.validate() and data.num_nodes == 10 and data.num_edges == 8
    np.testing.assert_array_equal(data.edge_index, [graph.source, graph.target])
    for name in ("action", "count", "reward", "terminal"):
        np.testing.assert_array_equal(data[name], getattr(graph, name))
    np.testing.assert_array_equal(data.phi, engine.potential())
    known = engine.eigenvectors()
    np.testing.assert_array_equal(data.x[: len(known)], known.astype(np.float32))
    assert data.x.shape == (10, known.shape[1]) and not data.x[9].any()
    either_way = to_scipy_sparse_matrix(data.edge_index, num_nodes=10)
    either_way = (either_way + either_way.T) > 0
    assert (either_way != (engine.to_scipy() > 0)).nnz == 0


def test_it_says_what_is_missing(monkeypatch):
    monkeypatch.setitem(sys.modules, "torch_geometric", None)
    with pytest.raises(ImportError, match=r"Engine.to_pyg needs torch_geometric: pip install eigentrail\[pyg\]"):
        explored().to_pyg()
