"""The examples of the README run."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

README = Path(__file__).parent.parent / "README.md"
EXAMPLES = re.findall(r"^```python\n(.*?)^```$", README.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("number", range(len(EXAMPLES)))
def test_it_runs(number):
    exec(compile(EXAMPLES[number], f"example {number + 1} of README.md", "exec"), {})


def test_the_first_one_has_five_lines():
    assert len(EXAMPLES) >= 3 and len(EXAMPLES[0].splitlines()) == 5
