from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_the_readme_shows_the_example_that_ci_runs():
    example = (ROOT / "examples" / "library.py").read_text().split('"""\n\n', 1)[1]
    assert f"```python\n{example}```\n" in (ROOT / "README.md").read_text()


def test_every_page_that_the_readme_names_is_there():
    import re

    for target in re.findall(r"\]\(([^)#]+)\)", (ROOT / "README.md").read_text()):
        assert (ROOT / target).is_file(), f"README.md names {target}, which doesn't exist"
