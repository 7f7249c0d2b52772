"""The examples run, and what they say of themselves holds."""

from __future__ import annotations

import runpy
from pathlib import Path
from xml.etree import ElementTree

EXAMPLES = Path(__file__).parent.parent / "examples"
LEARNING = Path(__file__).parent.parent / "benches" / "learning"


def test_q_learning_learns_with_and_without():
    main = runpy.run_path(str(EXAMPLES / "q_learning.py"))["main"]
    doors = ["--env-id", "MiniGrid-DoorKey-5x5-v0", "--key", "minigrid", "--total-timesteps", "8000"]
    wrapped, plain = main(doors), main([*doors, "--no-shaped", "--no-advised"])
    successes, without = (sum(value > 0 for value in returns) for returns in (wrapped, plain))
    assert successes > 50 and successes > 2 * without
    assert max(main(["--total-timesteps", "5000"])) >= -17.0  # of −13 at best


def test_a_picture_is_the_same_each_time_and_has_all_its_panels(tmp_path):
    main = runpy.run_path(str(EXAMPLES / "picture.py"))["main"]
    for name in ("one.svg", "other.svg"):
        main(["MiniGrid-Empty-6x6-v0", "--steps", "300", "-o", str(tmp_path / name)])
    text = (tmp_path / "one.svg").read_text(encoding="utf-8")
    assert text == (tmp_path / "other.svg").read_text(encoding="utf-8")
    titles = [node.text for node in ElementTree.fromstring(text).iter("{http://www.w3.org/2000/svg}text")]
    assert len(titles) == 4 and titles[0].startswith("φ at the first goal, step ")
    assert titles[1:] == ["φ at step 300, 52 states", "eigenvector 1", "eigenvector 2"]


def test_worlds_answered_from_memory_are_the_worlds():
    compare = runpy.run_path(str(LEARNING / "remembered.py"))["compare"]
    assert compare("MiniGrid-DoorKey-5x5-v0", layout=1, steps=2000) > 3
    assert compare("MiniGrid-MultiRoom-N2-S4-v0", layout=0, steps=2000) > 3
    compare("MiniGrid-KeyCorridorS3R1-v0", layout=0, steps=2000)
