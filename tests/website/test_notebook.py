"""The notebook of the examples runs from its first cell to its last."""

from __future__ import annotations

import json
import re
import sys
from types import ModuleType, SimpleNamespace

import pytest

from website.repository import ROOT

NOTEBOOK = json.loads((ROOT / "examples" / "first_look.ipynb").read_text(encoding="utf-8"))


def test_it_is_kept_without_what_it_printed():
    code = [cell for cell in NOTEBOOK["cells"] if cell["cell_type"] == "code"]
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in code)


@pytest.mark.long
def test_it_runs(tmp_path, monkeypatch, capsys):
    display = ModuleType("IPython.display")
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    shown = []
    monkeypatch.setattr(display, "HTML", shown.append, raising=False)
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(display=display))
    monkeypatch.chdir(tmp_path)
    space = {"__name__": "__main__"}
    for cell in NOTEBOOK["cells"]:
        if cell["cell_type"] == "code" and not cell["source"][0].startswith("%"):
            exec(compile("".join(cell["source"]), cell["id"], "exec"), space)
    assert "<html" in shown[0]
    assert re.search(r"cautious: goals [\d.]+% \[[\d.]+%, [\d.]+%\], collisions [\d.]+% \[", capsys.readouterr().out)
