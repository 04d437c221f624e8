"""The edges of a process: its environment, streams and signals. `tests/reliability/faults.py` plays many more."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import pytest

from jaxwalk.cli import main

JAXWALK = [sys.executable, "-m", "jaxwalk"]
STUCK = """
import hashlib, pathlib, time

class Asleep:
    def __init__(self):
        pathlib.Path("begun").touch()
        time.sleep(600)

class Stuck:
    def __init__(self):
        pathlib.Path("begun").touch()
        hashlib.pbkdf2_hmac("sha256", b"", b"", 2_000_000_000)  # as a compiler, it hears no signal
"""


GARBAGE = """
import atexit, gc
from jaxwalk.cli import main

atexit.register(lambda: print("frozen:", gc.get_freeze_count() > 0))  # called last, as it was registered first
main(["bench", "--help"])
print("new objects:", gc.get_threshold()[0])
"""


def shell(line, **environment):
    """What a shell makes of a line in which J stands for jaxwalk."""
    line = line.replace("J ", " ".join(JAXWALK) + " ")
    keep = {name: value for name, value in os.environ.items() if environment.get(name) != "-"}
    changed = keep | {name: value for name, value in environment.items() if value != "-"}
    command = ["bash", "-o", "pipefail", "-c", line]
    return subprocess.run(command, env=changed, capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.parametrize(
    ("variable", "value", "said"),
    [
        ("JAX_PLATFORMS", "nonsense", "Unable to initialize backend 'nonsense'"),
        ("JAX_NUM_CPU_DEVICES", "abc", 'Invalid value "abc" for JAX flag jax_num_cpu_devices'),
        ("XLA_FLAGS", "--nonsense", "Unknown flag in XLA_FLAGS: --nonsense"),
    ],
)
@pytest.mark.parametrize("command", ["observations", pytest.param("bench --quick", marks=pytest.mark.long)])
def test_a_wrong_variable_is_said_by_name(variable, value, said, command, place):
    done = shell(f"J {command}", **{variable: value})
    assert done.returncode == 2
    assert done.stderr.startswith(f"jaxwalk: JAX can't start ({said}")
    assert done.stderr.count("\n") == 1 and variable in done.stderr.rpartition("; correct or unset ")[2]


@pytest.mark.parametrize("lost", [{"XDG_CACHE_HOME": "/dev/null"}, {"JAX_COMPILATION_CACHE_DIR": "/dev/null/x"}])
def test_without_a_cache_folder_it_works_and_says_so(lost, place):
    done = shell("J observations", **{"JAX_COMPILATION_CACHE_DIR": "-"} | lost)
    assert (done.returncode, done.stdout.partition(":")[0]) == (0, "paper")
    assert done.stderr.startswith("jaxwalk: compiled code isn't kept") and done.stderr.count("\n") == 1


def test_a_user_without_a_home_is_served(place, monkeypatch, capsys):
    def home():
        raise RuntimeError("Could not determine home directory.")

    for name in ("JAX_COMPILATION_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("JAX_ENABLE_COMPILATION_CACHE", "true")
    monkeypatch.delenv("JAX_ENABLE_COMPILATION_CACHE")
    monkeypatch.setattr("pathlib.Path.home", home)
    assert main(["observations"]) == 0
    assert "Could not determine home directory" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "code", "out", "err"),
    [
        ("J observations | head -1", 0, "paper: 34 features\n", ""),
        ("J --help | head -0", 0, "", ""),
        ("J observations >&-", 0, "", ""),
        pytest.param("J observations 2>&- | head -1", 0, "paper: 34 features\n", "", marks=pytest.mark.long),
        ("J observations <&- >&- 2>&-", 0, "", ""),
        pytest.param("J observations --role nobody 2>&-", 2, "", "", marks=pytest.mark.long),
        ("J observations --role nobody 2>/dev/full", 2, "", ""),
        ("J --version >/dev/full", 2, "", "jaxwalk: No space left on device; make room on the disk"),
        ("J --help >/dev/full", 2, "", "jaxwalk: No space left on device; make room on the disk"),
    ],
)
def test_a_stream_may_be_closed_unread_or_full(line, code, out, err, place):
    done = shell(line)
    assert (done.returncode, done.stdout) == (code, out)
    assert done.stderr.startswith(err) and done.stderr.count("\n") <= 1


UNUSUAL = """
import sys
from jaxwalk.cli import commands, main

commands.run = lambda options: print("Stra\xdfe/a.svg") or 0
sys.argv = ["jaxwalk", "play"]
sys.exit(main())
"""


@pytest.mark.parametrize("ascii_only", ["ascii", "ascii:surrogateescape"])
def test_characters_that_the_terminal_lacks_are_escaped(ascii_only, place):
    """A command that prints a file's name."""
    environment = os.environ | {"PYTHONIOENCODING": ascii_only}
    done = subprocess.run([sys.executable, "-c", UNUSUAL], env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "Stra\\xdfe/a.svg\n", "")


LEAVING = """
import pathlib, sys, time
from jaxwalk.cli import main

class Last:
    def __del__(self, begin=pathlib.Path("begun").touch, sleep=time.sleep):
        begin()
        sleep(1)

last = Last()  # Python deletes it after it has given up its handlers of signals
sys.argv = ["jaxwalk", "--version"]
sys.exit(main())
"""


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="POSIX")
@pytest.mark.parametrize("sent", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_command_that_has_ended_is_not_ended_again_while_python_leaves(sent, place):
    """Seen once in faults.py: `observations` was done, and a hangup killed it without a word."""
    with subprocess.Popen([sys.executable, "-c", LEAVING], stderr=subprocess.PIPE, text=True) as process:
        while not (place / "begun").exists():
            assert process.poll() is None, process.stderr.read()
            time.sleep(0.05)
        process.send_signal(getattr(signal, sent))
        _, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (0, "")


INT, TERM, HUP = (getattr(signal, name, None) for name in ("SIGINT", "SIGTERM", "SIGHUP"))


@pytest.mark.long
@pytest.mark.skipif(HUP is None, reason="POSIX")
@pytest.mark.parametrize(
    ("driver", "sent", "code", "seconds"),
    [
        ("Asleep", [INT], 130, 2),
        ("Asleep", [TERM], 143, 2),
        ("Asleep", [HUP], 143, 2),
        ("Stuck", [INT], 130, 6),
        ("Stuck", [TERM, TERM], 143, 2),
        ("Stuck", [INT, INT], 130, 2),
    ],
)
def test_a_signal_ends_a_command_in_time(driver, sent, code, seconds, place):
    (place / "mine.py").write_text(STUCK)
    command = [*JAXWALK, "evaluate", "--driver", f"mine.py:{driver}", "--out", "kept"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        while not (place / "begun").exists():
            assert process.poll() is None, process.stderr.read()
            time.sleep(0.05)
        begun = time.monotonic()
        for number in sent:
            process.send_signal(number)
            time.sleep(0.5)
        try:
            out, err = process.communicate(timeout=60)
        finally:
            process.kill()
    assert (process.returncode, out, err) == (code, "", "jaxwalk: interrupted\n")
    assert time.monotonic() - begun < 3 * seconds  # on a busy machine
    assert not (place / "kept").exists()


def test_garbage_is_seldom_looked_for_and_not_at_the_end():
    done = subprocess.run([sys.executable, "-c", GARBAGE], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("new objects: 1000000\nfrozen: True\n")
