"""The world model and its walkers, for loops of your own."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _eigentrail, files

if TYPE_CHECKING:
    import networkx
    import scipy.sparse
    import torch_geometric.data

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


class Observed(NamedTuple):
    """What a step was worth."""

    node: int
    """Number of the state that was reached, in order of discovery."""
    shaping: float
    """F = γ φ(s′) − φ(s), to be added to the reward."""
    phi: float
    """φ of the state that was reached; 0 where the task is over."""
    new_node: bool
    """The state was not known before."""
    first_goal: bool
    """A goal was entered while none was known."""
    lost_goal: bool
    """The state was a goal until now, and the episode went on."""
    bonus: float
    """Reward for novelty under ``exploration={"kind": "count-bonus"}``, else 0. It is not potential-based."""
    refreshed: bool
    """Eigenvectors or the potential were brought up to date."""


class Transitions(NamedTuple):
    """Every (state, action, next state) seen, one entry each in every array, by state and in order of discovery."""

    source: Integers
    action: Integers
    target: Integers
    count: Integers  # type: ignore[assignment]
    """How often it was seen."""
    reward: Floats
    """Mean reward over those times."""
    terminal: npt.NDArray[np.bool_]
    """Whether an episode terminated on arrival."""


class Engine:
    """The graph of visited states, its spectrum, the potential φ, and walkers on it.

    ``num_actions`` and ``gamma`` are those of your agent; ``seed`` makes runs repeat; ``walkers`` is how many explorers
    share what they find. Other parameters are sections of a scenario as dictionaries: ``spectral``, ``deepwalk``,
    ``gcn``, ``shaping``, ``exploration`` and ``schedule``, with the names and defaults that ``eigentrail schema``
    tells.

    Keys are bytes; :func:`eigentrail.canonical` makes them of nearly anything. Arrays are read-only snapshots.

    A corridor of nine rooms, of which the last ends the episode; action 0 stays, action 1 goes on:

    >>> from eigentrail import Engine, canonical
    >>> engine = Engine(num_actions=2, gamma=1.0, exploration={"potential_advice": 20.0})
    >>> for episode in range(2):
    ...     room = 0
    ...     node = engine.begin_episode(canonical(room))
    ...     while room < 8:
    ...         action = int(engine.advice().argmax())
    ...         room += action
    ...         seen = engine.observe(action, canonical(room), -1.0, room == 8, False)
    ...         reward_to_learn_from = -1.0 + seen.shaping
    >>> engine.num_nodes
    9
    >>> bool((engine.potential()[1:] > engine.potential()[:-1]).all())
    True
    """

    def __init__(
        self,
        num_actions: int,
        gamma: float,
        *,
        seed: int = 0,
        walkers: int = 1,
        **params: dict[str, Any],
    ) -> None:
        self._core = _eigentrail.Engine(num_actions, gamma, seed, walkers, json.dumps(params))
        self._ambiguous: tuple[int, int] | None = None

    def begin_episode(self, key: bytes, walker: int = 0) -> int:
        """Begins an episode in the state with this key; its number. An episode under way is abandoned."""
        return self._core.begin_episode(key, walker)

    def observe(
        self,
        action: int,
        key: bytes,
        reward: float,
        terminated: bool,
        truncated: bool,
        walker: int = 0,
    ) -> Observed:
        """Takes in one step from where the walker stands.

        ``terminated`` means that the task is over, so that nothing follows and φ is 0; ``truncated`` that the clock ran
        out, so that the state keeps its φ.
        """
        seen, doubt = self._core.observe(action, key, reward, terminated, truncated, walker)
        if doubt is not None:
            self._ambiguous = doubt
        return Observed._make(seen)

    def advice(self, walker: int = 0) -> Floats:
        """Advice for where the walker stands: logits to add to a policy's, one per action, or values to add to Q when
        choosing. Before the first goal, when φ is flat and shaping 0, it leads to what is not known yet; after that, to what
        may be better, and is mostly 0. An agent that does nothing but follow advice asks for the way to the goal as well,
        with ``exploration={"potential_advice": 20.0}``."""
        return self._core.advice(walker)

    def look_ahead(self) -> Floats:
        """What φ as it stands advises in every state, n × actions: the rise of φ along each action, times
        ``potential_advice``. All 0 before the first goal."""
        return self._core.look_ahead()

    def potential(self) -> Floats:
        """φ of every state, by number."""
        return self._core.potential()

    def phi(self, state: bytes | int) -> float:
        """φ of one state, by key or by number. A state that was never seen has the lowest φ of the last fit."""
        if isinstance(state, bytes):
            node = self.node_of(state)
            state = 2**32 - 1 if node is None else node
        return self._core.phi(state)

    def eigenvalues(self) -> Floats:
        """The lowest eigenvalues of the graph's normalised Laplacian as of the last refresh, ascending."""
        return self._core.eigenvalues()

    def eigenvectors(self) -> Floats:
        """The eigenvectors that go with them, n × k, n as of the last refresh."""
        return self._core.eigenvectors()

    def refresh(self) -> None:
        """Brings the eigenvectors up to date now; by itself it is done as the graph grows."""
        self._core.refresh()

    def refit(self) -> None:
        """Brings eigenvectors and φ up to date now. Before anything has ended an episode or paid, φ stays flat."""
        self._core.refit()

    def node_of(self, key: bytes) -> int | None:
        """The number of a state; ``None`` if it was never seen."""
        return self._core.node_of(key)

    def key_of(self, node: int) -> bytes:
        """The key of a state."""
        return self._core.key_of(node)

    def keys(self) -> list[bytes]:
        """The keys of all states, by number."""
        return self._core.keys()

    def node(self, walker: int = 0) -> int | None:
        """Where the walker stands; ``None`` before the first episode."""
        return self._core.walker_node(walker)

    def in_episode(self, walker: int = 0) -> bool:
        """Whether an episode of the walker is under way."""
        return self._core.in_episode(walker)

    def goals(self) -> list[int]:
        """States that are believed to be goals, in order of discovery."""
        return self._core.goals()

    def spurious_maxima(self) -> list[int]:
        """States where φ as it stands would hold up an agent that climbs it, though a goal can be reached from there."""
        return self._core.spurious_maxima()

    @property
    def ambiguous(self) -> tuple[int, int] | None:
        """A state and an action whose outcome is known to depend on how the state was reached: the key gives one name
        to states that behave differently. ``None`` if nothing speaks for that."""
        return self._ambiguous

    @property
    def num_nodes(self) -> int:
        """States discovered so far."""
        return self._core.num_nodes

    @property
    def num_edges(self) -> int:
        """Undirected edges between them."""
        return self._core.num_edges

    @property
    def num_actions(self) -> int:
        """Actions, the same in every state."""
        return self._core.num_actions

    @property
    def num_walkers(self) -> int:
        """Explorers that share the model."""
        return self._core.num_walkers

    @property
    def steps(self) -> int:
        """Steps observed so far, of all walkers together."""
        return self._core.steps

    @property
    def gamma(self) -> float:
        """The discount in F."""
        return self._core.gamma

    def graph(self) -> Transitions:
        """Every transition seen, as arrays."""
        source, action, target, count, total, terminal = self._core.transitions()
        reward = total / count
        reward.flags.writeable = False
        return Transitions(source, action, target, count, reward, terminal)

    def to_scipy(self) -> scipy.sparse.csr_array:
        """The undirected graph as a symmetric SciPy matrix: 1 where a step was seen, either way."""
        from scipy import sparse

        indptr, indices, data = self._core.adjacency()
        return sparse.csr_array((data, indices, indptr), shape=(self.num_nodes, self.num_nodes))

    def to_networkx(self) -> networkx.MultiDiGraph:
        """The transitions as a NetworkX graph. Nodes have ``key`` and ``phi``; edges ``action``, ``count``, ``reward``
        and ``terminal``."""
        import networkx

        graph = networkx.MultiDiGraph()
        keys, potential = self.keys(), self.potential().tolist()
        graph.add_nodes_from(
            (node, {"key": key, "phi": phi}) for node, (key, phi) in enumerate(zip(keys, potential, strict=True))
        )
        columns = [column.tolist() for column in self.graph()]
        for source, action, target, count, reward, terminal in zip(*columns, strict=True):
            graph.add_edge(source, target, action=action, count=count, reward=reward, terminal=terminal)
        return graph

    def to_pyg(self) -> torch_geometric.data.Data:
        """The transitions as a PyTorch Geometric graph. Each transition is an edge with ``action``, ``count``, ``reward`` and
        ``terminal``; nodes have ``phi`` and ``x``, the eigenvectors as of the last refresh, 0 for states found since."""
        try:
            import torch
            import torch_geometric.data
        except ModuleNotFoundError as error:
            if error.name not in ("torch", "torch_geometric"):
                raise
            raise ImportError(f"Engine.to_pyg needs {error.name}: pip install eigentrail[pyg]") from error

        graph, vectors = self.graph(), self.eigenvectors()
        features = np.zeros((self.num_nodes, vectors.shape[1]))
        features[: len(vectors)] = vectors
        columns = graph._asdict()
        edges = np.stack([columns.pop("source"), columns.pop("target")])
        return torch_geometric.data.Data(
            x=torch.from_numpy(features).float(),
            edge_index=torch.from_numpy(edges),
            phi=torch.from_numpy(self.potential().copy()),
            num_nodes=self.num_nodes,
            **{name: torch.from_numpy(column.copy()) for name, column in columns.items()},
        )

    def to_bytes(self) -> bytes:
        """All of it, walkers in the middle of their episodes included; see :meth:`from_bytes`."""
        return self._core.to_bytes()

    @classmethod
    def from_bytes(cls, saved: bytes) -> Engine:
        """An engine that goes on to the bit as the one that was written down. (The watch for ambiguous keys begins anew.)"""
        engine = cls.__new__(cls)
        engine._core = _eigentrail.Engine.from_bytes(saved)
        engine._ambiguous = None
        return engine

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the engine to a file, which is there in full or as it was before."""
        files.write(path, self.to_bytes())

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Engine:
        """The engine in a file."""
        return files.read(path, cls.from_bytes)

    def __reduce__(self) -> tuple[Any, ...]:
        return (type(self).from_bytes, (self.to_bytes(),))

    def __repr__(self) -> str:
        return f"<eigentrail.Engine: {self.num_nodes} nodes, {self.num_edges} edges, {self.steps} steps>"
