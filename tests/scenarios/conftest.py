"""Scripts to read."""

from __future__ import annotations

import pytest

from jaxwalk.scenarios.crash_suite import CrashFileError
from jaxwalk.scenarios.xosc.script_reading import read_xosc


@pytest.fixture
def read(tmp_path):
    def reading(text, name="by-hand.xosc"):
        (tmp_path / name).write_text(text)
        return read_xosc(tmp_path / name)

    return reading


@pytest.fixture
def check_refused(read):
    """Check that a document is refused in one line, which names the file and says what is wrong."""

    def check(text, message):
        with pytest.raises(CrashFileError, match=r"by-hand\.xosc: ") as error:
            read(text)
        assert message in str(error.value)
        assert "\n" not in str(error.value)

    return check
