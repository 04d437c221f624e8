"""The page on extending shows the programs that CI runs, each word for word."""

from __future__ import annotations

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples" / "extending").glob("*.py"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_the_page_shows_the_example(example):
    program = example.read_text().split('"""\n\n', 1)[1]
    assert f"```python\n{program}```\n" in (ROOT / "docs" / "extending.md").read_text()


def test_the_page_shows_nothing_else():
    assert (ROOT / "docs" / "extending.md").read_text().count("```python\n") == len(EXAMPLES) > 0


def test_ci_runs_the_examples():
    assert "examples/extending/*.py" in (ROOT / ".ci" / "run").read_text()
