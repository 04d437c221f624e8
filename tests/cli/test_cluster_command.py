"""`jaxwalk evaluate --cluster` has the numbers of one evaluation, whatever dies meanwhile."""

from __future__ import annotations

import importlib.util
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from jaxwalk.cli import main
from jaxwalk.experiments.on_ray import ALONE

pytestmark = [
    pytest.mark.long,
    pytest.mark.usefixtures("lenient_processes"),
    pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason='needs pip install "jaxwalk[cluster]"'),
]
EVALUATE = [sys.executable, "-m", "jaxwalk", "evaluate", "--driver", "constant-speed", "--episodes", "2048"]
FILES = ("results.json", "suite.md", "episodes.csv")


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The folder of an evaluation in one process."""
    folder = tmp_path_factory.mktemp("whole")
    subprocess.run([*EVALUATE, "--out", str(folder)], check=True, capture_output=True)
    return folder


def same(folder, whole):
    return [name for name in FILES if (folder / name).read_bytes() != (whole / name).read_bytes()] == []


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_command_goes_on_and_a_worker_that_is_killed_costs_nothing(number, whole, place):
    command = [*EVALUATE, "--cluster", "local", "--out", "new"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            os.kill(_wait_for(lambda: workers(process.pid), process)[0], signal.SIGKILL)
            _wait_for(lambda: list(place.glob("new/parts/*/part.json")), process)
            children = descendants(process.pid)
            process.send_signal(number)
            _, said = process.communicate(timeout=60)
        finally:
            process.kill()
    assert process.returncode == 128 + number
    assert ": its worker died (WorkerCrashedError); it is played again" in said
    assert "of 4 parts are finished, and kept in new/parts; the same command goes on with the others" in said
    assert "Traceback" not in said
    kept = {path: path.stat().st_mtime_ns for path in place.glob("new/parts/*/part.json")}
    assert 0 < len(kept) < 4
    _wait_for(lambda: not [pid for pid in children if Path(f"/proc/{pid}").exists()])
    done = subprocess.run([*command, "--json"], capture_output=True, check=True)
    assert same(place / "new", whole)
    assert done.stdout == (whole / "results.json").read_bytes()
    assert not (place / "new" / "parts").exists()


def test_two_nodes_of_which_one_dies(whole, place, monkeypatch):
    for name, value in ALONE.items():
        monkeypatch.setenv(name, value)
    command = [sys.executable, str(Path(__file__).with_name("two_nodes.py"))]
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(command, text=True, **streams) as nodes:
        try:
            address, client = (nodes.stdout.readline().strip() for _ in range(2))
            subprocess.run([*EVALUATE, "--cluster", client, "--out", "client"], check=True)
            monkeypatch.setenv("RAY_ADDRESS", address)
            command = [*EVALUATE, "--cluster", "auto", "--out", "new"]
            with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
                _wait_for(lambda: len(workers(nodes.pid)) == 2, process)
                print(file=nodes.stdin, flush=True)
                _, said = process.communicate(timeout=300)
        finally:
            nodes.stdin.close()
            nodes.wait(60)
    assert "its worker died (" in said
    assert process.returncode == 0, said
    assert same(place / "new", whole)
    assert same(place / "client", whole)


def test_a_cluster_that_is_not_there_is_one_message(place, capsys, monkeypatch):
    assert main([*EVALUATE[3:], "--cluster", "ray://127.0.0.1:9", "--out", "new"]) == 2
    said = capsys.readouterr().err
    assert said.startswith(
        "jaxwalk: --cluster ray://127.0.0.1:9: can't be used ([Errno 111] Connection refused); check"
    )
    monkeypatch.setenv("RAY_ADDRESS", "127.0.0.1:9")
    assert main([*EVALUATE[3:], "--cluster", "auto", "--out", "new"]) == 2
    said = capsys.readouterr().err
    assert "--cluster auto (RAY_ADDRESS=127.0.0.1:9): can't be used ([Errno 111] Connection refused); start one" in said
    assert not list(place.glob("new/*.json"))


def workers(process):
    """The processes below one that play a part."""
    return [pid for pid, line in descendants(process).items() if line.startswith("ray::_played")]


def descendants(process):
    """The command line of each process below one."""
    lines, parents = {}, {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            parents[int(folder.name)] = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
            lines[int(folder.name)] = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode()
        except OSError:  # it has ended
            continue
    found, last = {}, {process}
    while last:
        last = {pid for pid, parent in parents.items() if parent in last and pid in lines}
        found |= {pid: lines[pid] for pid in last}
    return found


def _wait_for(found, process=None, seconds=300):
    until = time.monotonic() + seconds
    while not (result := found()):
        assert process is None or process.poll() is None, process.stderr.read()
        assert time.monotonic() < until
        time.sleep(0.05)
    return result
