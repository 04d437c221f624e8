"""One process at a time writes into a folder; one that was killed is in nobody's way."""

import subprocess
import sys

import pytest

from jaxwalk.cli import main
from jaxwalk.recipes import RECIPES
from jaxwalk.runs.folder import Run
from jaxwalk.runs.lock import InUseError, held

HOLD = """
import sys, time
from pathlib import Path
from jaxwalk.runs.lock import held
with held(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(600)
"""


@pytest.fixture
def other(tmp_path):
    """Another process that holds a run folder; and that folder."""
    folder = Run.create(tmp_path / "run", RECIPES["fast"]).path
    with subprocess.Popen([sys.executable, "-c", HOLD, str(folder)], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "held\n"
        yield process, folder
        process.kill()


def test_another_process_is_told_of_and_a_killed_one_forgotten(other):
    process, folder = other
    with pytest.raises(InUseError, match=r"run: another process is writing into it; wait until"), held(folder):
        pass
    process.kill()
    process.wait()
    with held(folder):
        assert (folder / ".lock").is_file()


def test_training_and_reproducing_there_is_refused_in_a_line(other, capsys):
    _, folder = other
    before = {path: path.read_bytes() for path in folder.iterdir()}
    assert main(["train", "--resume", str(folder)]) == 2
    assert capsys.readouterr().err.endswith(
        f"jaxwalk: {folder}: another process is writing into it; wait until that has ended, or name another folder\n"
    )
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


def test_it_is_free_again_after_a_failure(tmp_path):
    with pytest.raises(ZeroDivisionError), held(tmp_path):
        raise ZeroDivisionError
    with held(tmp_path):
        assert (tmp_path / ".lock").is_file()
