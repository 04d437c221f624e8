"""Parts as tasks of Ray, on one of our own: what fails, what is tried again, what is left. Players here are quick."""

from __future__ import annotations

import os
import signal
import sys
import time
from pathlib import Path

import pytest

from jaxwalk.experiments.on_ray import ALONE, ATTEMPTS, LOCAL, ClusterError, connected, cores_of_cluster, play_on_ray

os.environ.update(ALONE)  # Ray reads it when it is imported
ray = pytest.importorskip("ray")

pytestmark = pytest.mark.long
PARTS = ["1/3", "2/3", "3/3"]


@pytest.fixture(scope="module")
def scratch(lenient_processes):
    """A Ray with two cores, and its folder for temporary files."""
    before = signal.getsignal(signal.SIGTERM)
    with connected(LOCAL, 2) as folder:
        assert signal.getsignal(signal.SIGTERM) is before
        assert sys.stdout is sys.stderr
        yield folder
    assert not Path(folder).exists()
    assert not ray.is_initialized()


@pytest.fixture
def played(scratch):
    """Plays parts; returns what came, and the lines that were said."""

    def run(play):
        kept, said = {}, []
        play_on_ray(play, PARTS, kept.__setitem__, said.append)
        return kept, said

    return run


def test_every_part_is_played_by_a_worker_and_its_files_come_back(played):
    assert cores_of_cluster() == 2
    kept, said = played(lambda part: {"part": part.encode(), "process": str(os.getpid()).encode()})
    assert {part: files["part"].decode() for part, files in kept.items()} == {part: part for part in PARTS}
    assert str(os.getpid()).encode() not in [files["process"] for files in kept.values()]
    assert said == []


def test_it_uses_the_loopback_address_alone(scratch):
    assert [node["NodeManagerAddress"] for node in ray.nodes()] == ["127.0.0.1"]


def test_a_part_whose_worker_is_killed_is_played_again(played, tmp_path):
    def play(part):
        killed = tmp_path / part.replace("/", "-")
        if part != "1/3" and not killed.exists():
            killed.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return {}

    kept, said = played(play)
    assert sorted(kept) == PARTS
    expected = [f"part {part}: its worker died (WorkerCrashedError); it is played again" for part in PARTS[1:]]
    assert sorted(said) == expected


def test_a_part_that_kills_every_worker_is_given_up(played, tmp_path):
    def play(part):
        if part == "2/3":
            with (tmp_path / "attempts").open("a") as file:
                file.write(".")
            os.kill(os.getpid(), signal.SIGKILL)
        return {}

    with pytest.raises(
        ClusterError, match=r"^part 2/3: 4 workers died while they played it, the last by Worker.*; if mem"
    ):
        played(play)
    assert len((tmp_path / "attempts").read_text()) == ATTEMPTS


def test_a_part_that_fails_is_not_tried_again_and_a_message_says_why(played, tmp_path):
    def play(part):
        if part == "2/3":
            with (tmp_path / "attempts").open("a") as file:
                file.write(".")
            raise RuntimeError("no street\nand more")
        return {}

    with pytest.raises(ClusterError, match=r"^part 2/3 failed on .+: RuntimeError: no street$"):
        played(play)
    assert (tmp_path / "attempts").read_text() == "."


def test_our_own_errors_are_told_in_their_words(played):
    def play(part):
        from jaxwalk.evaluation.parts import PartError

        raise PartError(f"this is wrong with {part}; do that")

    with pytest.raises(ClusterError, match=r"^part ./3 failed on .+: this is wrong with ./3; do that$"):
        played(play)


def test_what_still_plays_is_ended_when_a_part_fails(played, tmp_path):
    def play(part):
        if part == "1/3":
            while not (tmp_path / "plays").exists():
                time.sleep(0.01)
            raise RuntimeError("fails")
        (tmp_path / "plays").write_text(str(os.getpid()))
        time.sleep(600)

    with pytest.raises(ClusterError, match="fails"):
        played(play)
    process = int((tmp_path / "plays").read_text())
    for _ in range(3000):
        if not Path(f"/proc/{process}").exists():
            break
        time.sleep(0.01)
    else:
        pytest.fail("a worker plays on")
