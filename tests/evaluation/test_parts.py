"""Folders of parts: what is said where there is none."""

from __future__ import annotations

import re

import pytest

from jaxwalk.evaluation.parts import PART, PartError, read_parts


@pytest.mark.parametrize(
    ("there", "said"),
    [
        ("1", "2, 3: have no part.json, so no finished parts are in them; evaluate those parts, or name their folders"),
        ("13", "2: has no part.json, so no finished part is in it; evaluate that part, or name its folder"),
    ],
)
def test_all_folders_without_a_finished_part_are_named(there, said, tmp_path, monkeypatch):
    """A cluster's tasks make their folders when they begin, so `parts/*` names those that failed too."""
    monkeypatch.chdir(tmp_path)
    folders = [tmp_path.relative_to(tmp_path) / name for name in "123"]
    for folder in folders:
        folder.mkdir()
    for name in there:
        (tmp_path / name / PART).write_text("{}")
    with pytest.raises(PartError, match=f"^{re.escape(said)}$"):
        read_parts(folders)
