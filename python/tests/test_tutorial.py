"""The tutorial runs, block by block, and prints what it says."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

TUTORIAL = Path(__file__).parent.parent.parent / "docs" / "tutorial.md"
BLOCKS = re.compile(r"^```python\n(.*?)^```$(?:\n\n```text\n(.*?)^```$)?", re.DOTALL | re.MULTILINE)


@pytest.mark.filterwarnings("ignore")
def test_it_prints_what_it_says():
    blocks = BLOCKS.findall(TUTORIAL.read_text(encoding="utf-8"))
    assert len(blocks) >= 8
    names: dict = {}
    for number, (code, expected) in enumerate(blocks, 1):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, f"block {number} of tutorial.md", "exec"), names)
        assert printed.getvalue().strip("\n") == expected.strip("\n"), f"block {number}"
