"""The programs of docs/training.md, with a tiny recipe in place of fast, and few updates."""

from __future__ import annotations

import re
from importlib.util import find_spec

import pytest

import jaxwalk.recipes
from website.blocks import blocks
from website.repository import ROOT

FEW = {"updates=200": "updates=2"}
PROGRAMS = [
    block for block in blocks("docs/training.md", (ROOT / "docs" / "training.md").read_text(encoding="utf-8"))
    if block.language == "python"
]  # fmt: skip


def _needs(text: str) -> str:
    """The package, other than ours, that a program imports."""
    found = [name for name in re.findall(r"^import (\w+)", text, re.MULTILINE) if name != "jaxwalk"]
    return found[0] if found else "jaxwalk"


def test_there_is_a_program_for_each_tracker():
    assert [_needs(block.text) for block in PROGRAMS] == ["jaxwalk", "wandb", "mlflow"]


@pytest.mark.long
@pytest.mark.parametrize("block", PROGRAMS, ids=lambda block: _needs(block.text))
@pytest.mark.filterwarnings("default")  # those of trackers are theirs
def test_a_program_runs(block, tiny, tmp_path, monkeypatch):
    if find_spec(_needs(block.text)) is None:
        pytest.skip(f"needs {_needs(block.text)}")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(jaxwalk.recipes.RECIPES, "fast", tiny)
    monkeypatch.setenv("WANDB_MODE", "offline")
    monkeypatch.setenv("MLFLOW_TRACKING_URI", f"sqlite:///{tmp_path}/tracked.db")
    text = block.text
    for many, few in FEW.items():
        text = text.replace(many, few)
    made: dict[str, object] = {}
    exec(compile(text, "docs/training.md", "exec"), made)
    assert made["trained"].updates == 2
