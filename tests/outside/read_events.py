"""Reads the event file of a seed with TensorBoard's own reader and compares it with the tables beside it.

    pip install tensorboard
    python tests/outside/read_events.py runs/NAME/TIME/seed-0000
"""

import csv
import struct
import sys
from pathlib import Path

from tensorboard.backend.event_processing.plugin_event_accumulator import EventAccumulator
from tensorboard.util import tensor_util

CLEANRL = ["charts/episodic_return", "charts/episodic_length", "charts/SPS", "losses/td_loss"]


def scalars(events, tag):
    return [(event.step, tensor_util.make_ndarray(event.tensor_proto).item()) for event in events.Tensors(tag)]


def read(folder):
    # 0: keep everything, as opposed to the sample that the page shows.
    events = EventAccumulator(str(folder), size_guidance={"tensors": 0})
    events.Reload()
    return events


def main(folder):
    events = read(folder)
    tags = events.Tags()["tensors"]
    kinds = {tag: events.SummaryMetadata(tag).plugin_data.plugin_name for tag in tags}
    assert all(kinds[tag] == "scalars" for tag in CLEANRL), kinds
    for group in ["charts", "losses", "graph", "spectral", "gcn", "potential"]:
        assert any(tag.startswith(group + "/") for tag in tags), f"{group}: {tags}"

    with open(folder / "episodes.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    for tag, column in [("charts/episodic_return", "return"), ("charts/episodic_length", "length")]:
        single = struct.Struct("f")
        expected = [(int(row["step"]), single.unpack(single.pack(float(row[column])))[0]) for row in rows]
        assert scalars(events, tag) == expected, tag

    states = sum(1 for _ in open(folder / "states.csv")) - 1
    assert kinds["potential/phi"] == kinds["spectral/residuals"] == "histograms", kinds
    buckets = tensor_util.make_ndarray(events.Tensors("potential/phi")[-1].tensor_proto)
    assert buckets.shape[1] == 3 and buckets[:, 2].sum() == states, buckets
    assert all(buckets[1:, 0] == buckets[:-1, 1]), "buckets leave no gap"

    assert kinds["potential/map"] == "images", kinds
    width, height, png = tensor_util.make_ndarray(events.Tensors("potential/map")[-1].tensor_proto)
    assert png.startswith(b"\x89PNG") and int(width) > 0 and int(height) > 0

    assert kinds["scenario"] == "text", kinds
    (text,) = tensor_util.make_ndarray(events.Tensors("scenario")[0].tensor_proto)
    assert b"[env]" in text and b"episodes" in text
    print(f"{len(tags)} tags, {len(rows)} episodes, {states} states")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
