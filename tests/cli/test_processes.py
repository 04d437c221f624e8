"""`jaxwalk train --processes`: what is refused, and how the launcher ends processes, most of which only wait here."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time

import pytest

from jaxwalk.cli import launcher, main
from jaxwalk.cli.errors import LOST
from jaxwalk.cli.group import Group, group_of, take_cores
from jaxwalk.cli.options import Train
from jaxwalk.recipes import RECIPES, with_training
from jaxwalk.runs import entry, training
from jaxwalk.runs.folder import CHECKPOINTS, METRICS, Run
from jaxwalk.runs.watchdog import LAUNCHED
from reliability.kill_training import board

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="JAX's processes don't find each other on Windows")
WAITS = """
import os, signal, sys, time
number, deed = sys.argv[1:]
def wait():
    for _ in range(120):
        if deed != "still" or number == "0":
            os.write(0, b".")
        time.sleep(0.5)
def end(*_):
    if number == "1" and deed == "crumbles":
        os.abort()
    os.write(int(os.environ["JAXWALK_LAUNCHED"]), b"saved\\n")
    sys.exit(3 if deed == "crumbles" else 143)
if number == "0" or deed != "has just started":
    signal.signal(signal.SIGTERM, end)
os.write(int(os.environ["JAXWALK_LAUNCHED"]), b"ready\\n")
if number == "1" and deed == "fails":
    print("a reason")
    sys.exit(2)
if number == "0" and deed == "refuses":
    os.write(int(os.environ["JAXWALK_LAUNCHED"]), b"jaxwalk: no\\n")
    sys.exit(2)
if number == "0" and deed == "aborts":
    print("a failed check", file=sys.stderr, flush=True)
    os.abort()
if deed == "ends":
    sys.exit(0)
if number == "1" and deed == "dies":
    os.kill(os.getpid(), signal.SIGKILL)
if deed == "dies":
    sys.exit(3)
wait()
"""
LATE = """
import sys, time
open("started-" + sys.argv[-1], "w").close()
time.sleep(sys.argv[-1] == "1")
from jaxwalk.cli import main
from jaxwalk.cli.signals import Signals
ignore = Signals.ignore
def ignore_late(self):
    time.sleep(3.0 * (sys.argv[-1] == "1"))
    ignore(self)
Signals.ignore = ignore_late
sys.exit(main())
"""
REFUSED = {
    "no processes": ("--processes 0", "--processes must be from 1 to 4,096, not 0"),
    "far too many": ("--processes 5000", "--processes must be from 1 to 4,096, not 5000"),
    "no coordinator": ("--processes 2 --process 0", "--coordinator and --process go together"),
    "which process": ("--processes 2 --coordinator a:1", "--coordinator and --process go together"),
    "no such process": ("--processes 2 --coordinator a:1 --process 2", "--process must be from 0 to 1"),
    "no port": ("--processes 2 --coordinator a --process 0", "--coordinator must be HOST:PORT"),
    "a port too high": ("--processes 2 --coordinator a:99999 --process 0", "--coordinator must be HOST:PORT"),
    "restarts of a scheduler": (
        "--processes 2 --coordinator a:1 --process 0 --restarts 1",
        "--restarts needs processes that this command starts",
    ),
    "restarts of one": ("--restarts 1", "--restarts needs processes that this command starts"),
    "uneven": ("--processes 2 --shards 3", "--processes must divide the training's 3 shards, not be 2"),
    "JAX runs": ("--processes 2 --coordinator a:1 --process 0", "JAX has started already"),
}


@pytest.fixture
def deed(monkeypatch, tmp_path):
    """Let the launcher start processes that do something else than to train."""
    script = tmp_path / "waits.py"
    script.write_text(WAITS)
    monkeypatch.setattr(launcher, "GRACE", 1.0)

    def choose(name):
        monkeypatch.setattr(
            launcher, "_command", lambda words, number: [sys.executable, str(script), str(number), name]
        )

    return choose


def launch(*words, capfd):
    code = main(["train", "--run", "new", "--processes", "2", *words])
    return code, capfd.readouterr().err


def send_after(seconds, number, happened=lambda: True):
    """Send a signal to this process some time after something has happened."""

    def send():
        while not happened():
            time.sleep(0.05)
        time.sleep(seconds)
        os.kill(os.getpid(), number)

    threading.Thread(target=send, daemon=True).start()


@pytest.mark.parametrize("name", REFUSED)
def test_options_that_make_no_sense_are_refused(name, place, capsys):
    words, said = REFUSED[name]
    assert main(["train", "--run", "new", *words.split()]) == 2
    assert said in " ".join(capsys.readouterr().err.split())
    assert not (place / "new").exists()


def test_shards_of_a_run_are_divided(place):
    Run.create(place / "run", with_training(RECIPES["fast"], shards=4))
    options = Train(resume=place / "run", processes=2, coordinator="node1:7777", process=1)
    assert group_of(options) == Group("node1:7777", 1, 2, devices=2)


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="only Linux keeps threads on cores")
@pytest.mark.parametrize(("process", "processes", "own"), [(0, 2, {0, 2}), (1, 2, {4, 5, 7}), (2, 6, None)])
def test_processes_of_one_machine_have_cores_of_their_own(process, processes, own, monkeypatch):
    """Five cores, some numbers are missing, as in a container; a scheduler divides them itself."""
    kept = {}
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {7, 5, 4, 2, 0})
    monkeypatch.setattr(os, "sched_setaffinity", lambda thread, cores: kept.update({thread: set(cores)}))
    group = Group("localhost:7777", process, processes, devices=1)
    monkeypatch.delenv(LAUNCHED, raising=False)
    take_cores(group)
    assert not kept
    monkeypatch.setenv(LAUNCHED, "2")
    take_cores(group)
    assert kept.get(os.getpid()) == own
    assert all(cores == own for cores in kept.values())


def test_a_launched_process_accepts_the_words_of_its_launcher(place, monkeypatch):
    Run.create(place / "run", with_training(RECIPES["fast"], shards=2))
    monkeypatch.setenv(LAUNCHED, "2")
    options = Train(resume=place / "run", processes=2, coordinator="127.0.0.1:7777", process=0, restarts=3)
    assert group_of(options) == Group("127.0.0.1:7777", 0, 2, devices=1)


def test_processes_that_end_well_end_it(place, deed, capfd):
    deed("ends")
    assert launch(capfd=capfd) == (0, "ready\n")


def test_a_process_that_is_killed_ends_all_with_one_message(place, deed, capfd):
    deed("dies")
    code, said = launch(capfd=capfd)
    assert code == 3
    assert said.replace("ready\n", "") == (
        "jaxwalk: process 1 of 2 was killed (SIGKILL), and the training ended; there is no checkpoint yet; "
        "resume it with: jaxwalk train --run new --processes 2\nProcess 1 said:\n"
    )


def test_it_begins_again_as_often_as_asked(place, deed, capfd):
    deed("dies")
    code, said = launch("--restarts", "2", capfd=capfd)
    assert (code, said.count("it begins again"), said.count("resume it with")) == (3, 2, 1)


def test_one_that_gives_no_sign_of_life_ends_all(place, deed, capfd, monkeypatch):
    monkeypatch.setattr(launcher, "SILENCE", 3.0)
    deed("still")
    code, said = launch(capfd=capfd)
    assert (code, "jaxwalk: process 1 of 2 gave no sign of life for 3.0 s, and" in said) == (3, True)


def test_one_that_crashes_ends_all(place, deed, capfd):
    deed("aborts")
    code, said = launch(capfd=capfd)
    assert code == 3
    assert "jaxwalk: process 0 of 2 was killed (SIGABRT), and" in said
    assert said.endswith("\nProcess 0 said:\na failed check\n")


def test_what_process_0_refuses_is_said_once(place, deed, capfd):
    deed("refuses")
    assert launch(capfd=capfd) == (2, "ready\njaxwalk: no\n")


def test_what_another_process_says_is_shown_if_it_fails(place, deed, capfd):
    deed("fails")
    code, said = launch(capfd=capfd)
    assert (code, said) == (2, "ready\njaxwalk: process 1 of 2 failed:\nready\na reason\n")


@pytest.mark.parametrize(("words", "first"), [("--run new", True), ("--resume old", True), ("--resume old", False)])
def test_one_that_is_lost_before_they_meet_ends_it_with_one_message(words, first, place, monkeypatch, capfd):
    def refused():
        raise RuntimeError("Gloo context initialization failed: timed out connecting: Connection refused")

    Run.create(place / "old", RECIPES["fast"])
    monkeypatch.setattr(entry, "is_first", lambda: first)
    monkeypatch.setattr(training, "several", lambda: True)
    monkeypatch.setattr(training, "wait_for_all", refused)
    monkeypatch.setattr(entry, "train_in", None)
    assert main(["train", *words.split()]) == LOST
    said = "jaxwalk: another process of the training ended, or can't be reached any more; start all again\n"
    assert capfd.readouterr().err == said


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_is_handed_on_and_all_end_in_order(number, place, deed, capfd):
    deed("waits")

    send_after(1.5, number)
    assert launch(capfd=capfd) == (130, "ready\nsaved\n")


@pytest.mark.parametrize("name", ["crumbles", "has just started"])
def test_a_signal_that_the_processes_do_not_survive_in_order_loses_none(name, place, deed, capfd):
    """One is aborted by JAX, as the other leaves first; or the signal comes before a process listens."""
    deed(name)
    send_after(1.5, signal.SIGTERM)
    code, said = launch(capfd=capfd)
    assert (code, said) == (
        130,
        "ready\nsaved\njaxwalk: interrupted; there is no checkpoint yet; "
        "resume it with: jaxwalk train --run new --processes 2\n",
    )


def test_what_failed_before_a_signal_is_not_told_as_interrupted(place, deed, capfd, monkeypatch):
    deed("aborts")
    monkeypatch.setattr(launcher, "GRACE", 20.0)
    send_after(3.0, signal.SIGTERM)
    code, said = launch(capfd=capfd)
    assert code == 3 and "process 0 of 2 was killed (SIGABRT)" in said and "a failed check" in said, said


@pytest.mark.long
@pytest.mark.parametrize("moment", ["start", "training"])
def test_a_training_of_two_processes_is_interrupted_in_order(moment, place, monkeypatch, capfd):
    """Process 1 takes long to leave: JAX would abort it if process 0 left first. At the start it doesn't listen yet."""
    script = place / "late.py"
    script.write_text(LATE)
    monkeypatch.setattr(
        launcher, "_command", lambda words, number: [sys.executable, str(script), *words, "--process", str(number)]
    )
    metrics = place / "new" / METRICS
    happened = {
        "start": lambda: len(list(place.glob("started-*"))) == 2,
        "training": lambda: metrics.is_file() and metrics.stat().st_size,
    }[moment]
    send_after(0.0, signal.SIGTERM, happened)
    words = "--environments 8 --steps 8 --minibatches 2 --updates 100000"
    code, said = launch(*words.split(), capfd=capfd)
    assert (code, "Interrupted after" in said) == (130, moment == "training"), said
    if moment == "training":
        (kept,) = (place / "new" / CHECKPOINTS).iterdir()
        assert f"Interrupted after {kept.name} update" in said


def test_what_is_resumed_has_the_options_of_a_resumed_training(place):
    Run.create(place / "new", RECIPES["fast"])
    options = Train(run_folder=place / "new", processes=2, seed=3, watch=True, checkpoint_minutes=0.5)
    assert launcher._words_to_resume(options, ["train"]) == [
        "train", "--resume", str(place / "new"), "--processes", "2", "--watch", "--checkpoint-minutes", "0.5",
    ]  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("recipe", ["fast", "paper"])
def test_two_processes_write_what_one_with_two_shards_writes(recipe, place):
    """Policy file and metrics to the bit; and one process goes on with what two have begun."""
    words = f"--recipe {recipe} --environments 8 --steps 8 --minibatches 2 --updates 4"
    for name, how in {"one": "--shards 2", "two": "--processes 2"}.items():
        command = [sys.executable, "-m", "jaxwalk", "train", "--run", name, *words.split(), *how.split()]
        subprocess.run(command, check=True, cwd=place)
    one, two = Run.open(place / "one"), Run.open(place / "two")
    assert one.hash == two.hash
    assert two.policy.read_bytes() == one.policy.read_bytes()
    assert _timeless(two) == _timeless(one)
    assert board(two.path) == board(one.path)
    subprocess.run([sys.executable, "-m", "jaxwalk", "train", "--resume", "two"], check=True, cwd=place)
    assert Run.open(place / "two").policy.read_bytes() == one.policy.read_bytes()


def _timeless(run):
    return [{name: x for name, x in line.items() if name != "seconds"} for line in run.metrics()]
