"""``jaxwalk live``, as a user types it."""

from __future__ import annotations

import socket

import pytest

from jaxwalk.cli import main
from jaxwalk.live.live_offer import offer_of
from jaxwalk.sim.suites import Where


def test_it_says_its_address_and_ends_after_the_time(place, capsys):
    assert main(["live", "--port", "0", "--minutes", "0.001", "--out", "there"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("Open http://127.0.0.1:") and said.endswith("Ctrl-C ends the server\n")
    assert not (place / "there").exists()


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("--port 70000", "--port must lie in [0, 65,535]"),
        ("--port -1", "--port must lie in [0, 65,535]"),
        ("--minutes 0", "--minutes must be above 0"),
        ("--minutes nan", "--minutes must be above 0"),
        ("--people 0", "--people must lie in [1, 1,000]"),
        ("--scenarios nowhere", "nowhere: no such file"),
        ("--scenarios . --people 3", "--people: --scenarios . decides it"),
        ("--driver nobody", "no driver of that name"),
    ],
)
def test_options_that_make_no_sense(line, message, place, capsys):
    assert main(["live", "--out", "there", *line.split()]) == 2
    err = " ".join(capsys.readouterr().err.split())
    assert message in err and err.count("jaxwalk: ") == 1


def test_a_port_that_is_taken(place, capsys):
    with socket.create_server(("127.0.0.1", 0)) as other:
        taken = other.getsockname()[1]
        assert main(["live", "--port", str(taken)]) == 2
    assert f"port {taken}: Address already in use; name another one, or 0" in capsys.readouterr().err


def test_without_the_extra_it_says_what_to_install(place, capsys, monkeypatch):
    monkeypatch.setattr("jaxwalk.cli.live.find_spec", lambda _: None)
    assert main(["live"]) == 2
    assert "pip install 'jaxwalk[live]'" in capsys.readouterr().err


def test_what_is_named_comes_first():
    offer = offer_of(["mine.py:Mine"], [], Where(("my.toml", "test-2000000001"), None, 30))
    assert list(offer.streets.items())[:3] == [
        ("my.toml", "paper-footprint"),
        ("test-2000000001", "town"),
        ("paper", "paper"),
    ]
    assert (offer.drivers[0], offer.pedestrians[0], offer.start.places) == ("mine.py:Mine", "learned", 30)
    assert "oracle" in offer.drivers and "co-trained-0.1" not in offer.drivers
    assert 30 in offer.places and "test-track" not in offer.worlds
