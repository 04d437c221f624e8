from __future__ import annotations

import pytest

from jaxwalk.policies import AlwaysGo, RouteFollower
from jaxwalk.search.driving import Driving

BATCH = 16  # everywhere, so that little is compiled


@pytest.fixture(scope="session")
def game(street):
    """A driver that sees nobody, so that many scenarios fail."""
    return Driving(street, {"driver": RouteFollower(), "pedestrian": AlwaysGo()}, 3, batch=BATCH)
