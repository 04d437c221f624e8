"""A failure as `jaxwalk search` keeps it: a point of the cube, and who is there."""

from __future__ import annotations

import numpy as np

from jaxwalk.policies import AlwaysGo, RouteFollower
from jaxwalk.scenarios import Drawn
from jaxwalk.scenarios.archived import Archived

NUMBER = 1
"""A scenario of seed 0 in which the route follower turns and hits somebody on the paper's street."""
POLICIES = {"driver": RouteFollower(), "pedestrian": AlwaysGo()}


def kept_failure(street):
    """Return the failure with three of twelve people left out."""
    present = np.arange(12) != np.array([[3], [7], [9]])
    points = Drawn(street, 0).points(np.array([NUMBER]))
    return Archived(street, points, present.all(axis=0)[None], 0, np.array([NUMBER]))
