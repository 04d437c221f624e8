"""The page of a training: it follows the numbers beside it, without being asked or opened again."""

from __future__ import annotations

import math
import re

import pytest

from jaxwalk.recipes import RECIPES
from jaxwalk.runs.folder import Run
from jaxwalk.runs.progress import Pace
from jaxwalk.runs.watch import WatchPage

pytestmark = pytest.mark.long


def _line(update):
    """Goals rise from 0 to 1; nothing has ended in the first update."""
    goals = update / 100
    return {
        "update": update, "seconds": 2.0 * update, "episodes": float(update > 1),
        "goal_rate": goals, "collision_rate": 0.5 - goals / 2, "timeout_rate": 0.5 - goals / 2,
        "reward/driver": goals - 0.2, "reward/pedestrian": -0.001, "learning_rate": 1e-3 * (1 - goals),
        "driver/entropy": 1 / update, "pedestrian/entropy": 0.1, "driver/kl": 0.01, "driver/policy_loss": -1e-5,
    }  # fmt: skip


@pytest.fixture
def training(tmp_path):
    """The page of a training of 100 updates, 30 of them made by an earlier session."""
    run = Run.create(tmp_path / "run", RECIPES["fast"])
    return WatchPage(run, "co-trained", Pace(30, 100, 1000), [_line(u) for u in range(1, 31)])


def _make(watched, updates):
    watched._written = -math.inf  # as if nothing had been written for long
    watched._pace.begin(updates - 1)
    watched._pace.made = updates
    watched.show(_line(updates))


def _count(page, what):
    return page.locator(what).count()


def test_it_follows_a_training_from_start_to_end(training, open_file):
    with training:
        page = open_file(training.path)
        page.get_by_text("Starting: compiling").wait_for()
        assert page.get_by_text("Update 30 of 100.").is_visible()
        page.evaluate("window.opened = 'once'")
        _make(training, 31)
        page.get_by_text("Update 31 of 100.").wait_for()
        assert page.get_by_role("status").inner_text() == "Training."
        assert page.get_by_role("progressbar").evaluate("bar => bar.value / bar.max") == 0.31
        assert page.get_by_text(re.compile("^goals 31.0 %$")).is_visible()
    page.get_by_text("Stopped: jaxwalk train --resume continues it").wait_for()
    training._pace.made = 100
    with training:
        pass
    page.get_by_text("Finished.").wait_for()
    assert page.title() == "100 % finished: co-trained"
    assert page.evaluate("window.opened") == "once"
    assert _count(page, "script") <= 2


def test_every_rate_names_what_it_is_over(training, open_file):
    """Once 57.6 % and 75.0 % of goals stood there at the same time."""
    training._lines = [_line(u) for u in range(1, 200)]
    training._pace.made = 99
    with training:
        page = open_file(training.path)
        page.get_by_role("img").first.wait_for()
        facts = dict(zip(page.locator("dt").all_inner_texts(), page.locator("dd").all_inner_texts(), strict=True))
        assert facts["goals, updates 190 to 199"] == "194.5 %"
        assert page.locator("#points").inner_text() == (
            "Curves: each point is the mean of up to 2 updates. The number beside a name is the last point: "
            "updates 198 to 199."
        )
        assert page.get_by_text(re.compile("^goals 198.5 %$")).is_visible()


def test_charts_say_in_words_what_they_show(training, open_file):
    with training:
        page = open_file(training.path)
        page.get_by_role("img").first.wait_for()
        said = [chart.get_attribute("aria-label") for chart in page.get_by_role("img").all()]
    assert said[0] == (
        "How episodes ended [%]: goals 2.0 % at update 2, 30.0 % at 30; collisions 49.0 % at update 2, 35.0 % at 30; "
        "timeouts 49.0 % at update 2, 35.0 % at 30."
    )
    assert [words.split(":")[0] for words in said[1:3]] == [
        "Reward per step, unscaled",
        "Entropy of the actions",
    ]
    assert not any("NaN" in words or "undefined" in words for words in said)
    assert "NaN" not in page.locator("#charts").inner_html()


def test_it_can_be_paused_with_the_keyboard(training, open_file):
    with training:
        page = open_file(training.path)
        page.get_by_text("Update 30 of 100.").wait_for()
        page.keyboard.press("Tab")
        page.keyboard.press("Enter")
        assert page.get_by_role("button", name="Pause this page", pressed=True).is_visible()
        _make(training, 40)
        page.wait_for_timeout(2500)
        assert page.get_by_text("Update 30 of 100.").is_visible()
        page.keyboard.press("Enter")
        page.get_by_text("Update 40 of 100.").wait_for()


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1100, 360])
def test_it_shuts_nobody_out(training, open_file, check_access, page, scheme, width):
    page.emulate_media(color_scheme=scheme)
    page.set_viewport_size({"width": width, "height": 800})
    with training:
        open_file(training.path)
        page.get_by_role("img").first.wait_for()
        check_access(page)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
