"""One batch of real episodes, recorded once."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.formats.areas import areas_of, parse_areas
from jaxwalk.formats.road_network import road_network
from jaxwalk.formats.tracks import tracks_of
from jaxwalk.maps import load_network
from jaxwalk.scenarios import Drawn

EPISODES = 48


@pytest.fixture(scope="session")
def network():
    return load_network("paper")


@pytest.fixture(scope="session")
def areas(network):
    return parse_areas(areas_of(network), "the map")


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


TOWN = "test-2000000003"
"""Two junctions, bent roads of one to four lanes, an island, parking strips, buildings."""


@pytest.fixture(scope="module", params=["paper", TOWN])
def road_plan(request):
    return road_network(load_network(request.param))
