"""One batch of real episodes, recorded once."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.formats.areas import areas_of, parse_areas
from jaxwalk.formats.tracks import tracks_of
from jaxwalk.maps import load_map
from jaxwalk.scenarios import Drawn

EPISODES = 48


@pytest.fixture(scope="session")
def road_map():
    return load_map("paper")


@pytest.fixture(scope="session")
def areas(road_map):
    return parse_areas(areas_of(road_map), "the map")


@pytest.fixture(scope="session")
def recorded(street):
    """The route follower among people who always go: goals, collisions and encounters of both types."""
    from jaxwalk.evaluation import play
    from jaxwalk.policies import DRIVERS, POPULATIONS

    scenarios, keys = Drawn(street, 0).take(np.arange(EPISODES))
    return play(
        street, {"driver": DRIVERS["route-follower"](), "pedestrian": POPULATIONS["always-go"]()}, scenarios, keys
    )


@pytest.fixture(scope="session")
def episodes(recorded):
    """Its tables."""
    return list(tracks_of(recorded))
