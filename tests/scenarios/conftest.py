"""Scripts to read."""

from __future__ import annotations

import pytest

from jaxwalk.scenarios.xosc.script_reading import read_xosc


@pytest.fixture
def read(tmp_path):
    def reading(text, name="by-hand.xosc"):
        (tmp_path / name).write_text(text)
        return read_xosc(tmp_path / name)

    return reading
