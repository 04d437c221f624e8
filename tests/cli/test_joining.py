"""A process that starts JAX and finds the others: one that is lost meanwhile is told from a JAX that can't start."""

from __future__ import annotations

import platform
import sys
from types import SimpleNamespace

import pytest

from jaxwalk.cli import jax_start, main
from jaxwalk.cli.errors import BAD_INPUT, LOST

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="JAX's processes don't find each other on Windows")
CLOSED = "UNAVAILABLE: Socket closed while calling /xla.coordination.CoordinationService/GetKeyValue"
"""What JAX says when process 0 is killed while the others tell each other about their devices."""


@pytest.fixture
def joining(monkeypatch):
    """Let the command join others with an error, as if JAX hadn't started in this process."""

    def fail(error):
        def join(group):
            raise RuntimeError(error)

        monkeypatch.setenv(jax_start.DEVICES, "1")
        monkeypatch.delenv("XLA_FLAGS", raising=False)  # or another process reads them
        monkeypatch.setattr(jax_start, "sys", SimpleNamespace(modules={}, stderr=sys.stderr))
        monkeypatch.setattr(jax_start, "join", join)
        words = "--processes 2 --coordinator 127.0.0.1:7777 --process 1"
        return main(["train", "--run", "new", *words.split()])

    return fail


def test_one_that_is_lost_while_the_others_start_can_be_begun_again(joining, capfd):
    assert joining(f"Unable to initialize backend 'cpu': {CLOSED}") == LOST
    said = "jaxwalk: another process of the training ended, or can't be reached any more; start all again\n"
    assert capfd.readouterr().err == said


def test_a_jax_that_cannot_start_is_bad_input(joining, capfd):
    assert joining("Unable to initialize backend 'cup'") == BAD_INPUT
    assert "jaxwalk: JAX can't start (Unable to initialize backend 'cup')" in capfd.readouterr().err


def test_a_machine_without_an_address_of_its_own_is_told_what_it_lacks(joining, capfd):
    found = "[enforce fail at gloo/gloo/transport/tcp/device.cc:99] rv == 0. -2 vs 0 (or set JAX_PLATFORMS=cpu)"
    assert joining(found) == BAD_INPUT
    assert f"an address for this machine's name, {platform.node()}, such as in /etc/hosts" in capfd.readouterr().err
