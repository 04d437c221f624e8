"""What the page of a training is told."""

import json
import re

import pytest

from jaxwalk.runs.folder import Run
from jaxwalk.runs.progress import Display
from jaxwalk.runs.training import train_in
from jaxwalk.runs.watch import POINTS, curves


def _told(run):
    text = (run.path / "watch.js").read_text(encoding="utf-8")
    return json.loads(re.fullmatch(r"show\((.*)\);\n", text)[1])


def test_endings_weigh_as_much_as_episodes():
    n = 2 * POINTS
    lines = [{"update": i, "episodes": float(i % 2), "goal_rate": i / n, "driver/kl": 1.0 * i} for i in range(1, n + 1)]
    found = curves(lines)
    assert found["at"] == list(range(2, n + 1, 2))
    assert found["curves"]["goal_rate"] == pytest.approx([i / n for i in range(1, n + 1, 2)], rel=1e-4)
    assert found["curves"]["driver/kl"] == pytest.approx([i + 0.5 for i in range(1, n + 1, 2)], rel=1e-4)


def test_what_is_not_known_is_null():
    first = {"update": 1, "episodes": 0.0, "goal_rate": 0.0}
    found = curves([first, {**first, "update": 2, "episodes": 2.0, "goal_rate": 0.5}])
    assert found == {
        "at": [1, 2],
        "curves": {"goal_rate": [None, 0.5]},
        "recent": {"goal_rate": 0.5},
        "recent_updates": 2,
    }
    assert curves([]) == {"at": [], "curves": {}, "recent": {}, "recent_updates": 0}


def test_recent_endings_are_those_of_the_last_ten_updates():
    lines = [{"update": i, "episodes": 1.0 + (i == 20), "goal_rate": float(i > 15)} for i in range(1, 21)]
    assert curves(lines)["recent"] == {"goal_rate": pytest.approx(6 / 11, rel=1e-4)}
    assert curves(lines)["recent_updates"] == 10


@pytest.mark.long
def test_a_watched_training_writes_its_page_and_resuming_goes_on_with_it(tiny, tmp_path, quiet, monkeypatch):
    run = Run.create(tmp_path / "run", tiny)
    with monkeypatch.context() as interrupted:
        interrupted.setattr("jaxwalk.runs.training.Stop.requested", True)
        train_in(run, display=Display(quiet, watch=True))
    assert "watch.html in a browser" in quiet.file.getvalue()
    assert (_told(run)["status"], _told(run)["update"], _told(run)["curves"]) == ("stopped", 0, {})
    train_in(Run.open(run.path), resume=True, display=Display(quiet))
    told = _told(run)
    assert (told["status"], told["update"], told["planned"], told["steps"]) == ("finished", 6, 6, 384)
    assert told["at"] == [1, 2, 3, 4, 5, 6]
    assert told["curves"]["driver/entropy"] == pytest.approx([m["driver/entropy"] for m in run.metrics()], rel=1e-4)


def test_a_training_that_fails_says_so(whole, tiny, tmp_path, quiet, monkeypatch):
    def broken(*_):
        raise RuntimeError("out of order")

    monkeypatch.setattr("jaxwalk.learning.mappo.update", broken)
    run = Run.create(tmp_path / "run", tiny)
    with pytest.raises(RuntimeError, match="out of order"):
        train_in(run, display=Display(quiet, watch=True))
    assert _told(run)["status"] == "failed"


def test_nobody_who_does_not_watch_gets_a_page(whole):
    assert not list(whole.path.glob("watch.*"))
