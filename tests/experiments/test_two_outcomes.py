"""The collision of figure 1 is chosen by a fixed rule, whatever else the gallery holds."""

from __future__ import annotations

import pytest

from jaxwalk.experiments.two_outcomes import jaywalker_hit
from jaxwalk.report import DrawnEpisode, Gallery
from jaxwalk.report.watched import WatchedEpisode, WatchedIncident
from jaxwalk.viewer.drawn_map import DrawnMap

EMPTY = DrawnMap(1.0, 1.0, {}, [], [], [])


def _gallery(*incidents):
    """A gallery of (driver, kind, contact, moving, speed), each in a scenario of its own: 10, 11, ..."""
    episodes = tuple(
        WatchedEpisode(driver, "learned", 0.25, 10 + n, "collision", 80 + n, 0, "")
        for n, (driver, *_) in enumerate(incidents)
    )
    watched = tuple(
        WatchedIncident(n, kind, contact, moving, 0, 8.0, "", "", None, speed, None, None, None)
        for n, (_, kind, contact, moving, speed) in enumerate(incidents)
    )
    return Gallery(0.1, (EMPTY,), episodes, 3.0, 20, 500, watched)


BLIND = ("route-follower", "collision", "jaywalk", True, 8.3)


@pytest.mark.parametrize(
    ("incidents", "driver", "scenario", "frame"),
    [
        ([BLIND, ("co-trained", "collision", "jaywalk", True, 2.0)], "co-trained", 11, 81),
        ([("single-agent", "collision", "jaywalk", True, speed) for speed in (3.0, 5.0, 4.0)], "single-agent", 11, 81),
        (
            [
                ("co-trained", "near miss", "jaywalk", True, None),
                ("co-trained", "collision", "crosswalk", True, 8.0),
                ("co-trained", "collision", "jaywalk", False, 0.0),
                BLIND,
            ],
            "route-follower", 13, 83,
        ),
    ],
)  # fmt: skip
def test_the_fastest_of_the_first_driver_that_hit_a_jaywalker(incidents, driver, scenario, frame):
    found = jaywalker_hit(_gallery(*incidents))
    assert found == DrawnEpisode(scenario, 0, 0, frame, driver, "learned")


def test_nobody_hit():
    assert jaywalker_hit(_gallery(("co-trained", "near miss", "jaywalk", True, None))) is None
