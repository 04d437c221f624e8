"""Reports whose figures nobody looks at."""

from __future__ import annotations

import pytest

from jaxwalk.report.figures import FIGURES


@pytest.fixture
def undrawn(monkeypatch):
    """Figures are left empty: drawing them takes seconds, and they are as in the other reports."""
    monkeypatch.setattr("jaxwalk.report.write.draw_all", lambda *_: dict.fromkeys(FIGURES, ""))
