"""Reads the exports of a run with the programs they are meant for; `tests/export.rs` makes the folder.

    pip install duckdb networkx numpy pandas pyarrow
"""

import sys
from pathlib import Path

import duckdb
import networkx
import numpy
import pandas

TABLES = ["episodes", "refreshes", "states", "transitions"]


def main(folder):
    tables = {name: pandas.read_csv(folder / "csv" / f"{name}.csv") for name in TABLES}
    with numpy.load(folder / "run.npz") as arrays:
        for name, table in tables.items():
            for column in table:
                array = arrays[f"{name}/{column}"]
                if array.dtype.kind == "U":
                    assert list(array) == list(table[column]), (name, column)
                else:
                    numpy.testing.assert_array_equal(array.astype(float), table[column].astype(float))
        vectors = arrays["eigenvectors/seed-0000"]
        numpy.testing.assert_allclose(vectors.T @ vectors, numpy.eye(vectors.shape[1]), atol=1e-9)

    for name in TABLES if (folder / "parquet").is_dir() else []:
        path = folder / "parquet" / f"{name}.parquet"
        by_pandas, expected = pandas.read_parquet(path), tables[name]
        assert list(by_pandas) == list(expected), name
        for column in expected:
            if expected[column].dtype == by_pandas[column].dtype == float:
                numpy.testing.assert_array_equal(by_pandas[column], expected[column])
            else:
                same = by_pandas[column].astype(object).eq(expected[column].astype(object))
                assert (same | expected[column].isna() & by_pandas[column].isna()).all(), (name, column)
        count, least = duckdb.sql(f"select count(*), min(seed) from '{path}'").fetchall()[0]
        assert (count, least) == (len(expected), 0), name
    if (folder / "parquet").is_dir():
        path = folder / "parquet" / "episodes.parquet"
        query = f"""select sum("return"), any_value(status), sum(nodes) from '{path}' where seed = 3"""
        reward, status, nodes = duckdb.sql(query).fetchall()[0]
        seed = tables["episodes"][tables["episodes"].seed == 3]
        assert reward == seed["return"].sum() and nodes == seed.nodes.sum() and isinstance(status, str)

    graph = networkx.read_graphml(folder / "graph.graphml")
    states, transitions = (tables[name][tables[name].seed == 0] for name in ["states", "transitions"])
    assert graph.number_of_nodes() == len(states) and graph.number_of_edges() == len(transitions)
    assert sum(count for *_, count in graph.edges(data="count")) == transitions["count"].sum()
    phi = [graph.nodes[f"n{state}"]["phi"] for state in states.state]
    numpy.testing.assert_array_equal(phi, states.potential)
    print(", ".join(f"{len(table)} {name}" for name, table in tables.items()))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
