"""Children of MAP-Elites: none is its parent's copy."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from jaxwalk.scenarios.archived import scenarios_at
from jaxwalk.search.cube import EDGE, Candidates, ordinary
from jaxwalk.search.elites import Elites
from jaxwalk.search.grid import CELLS
from jaxwalk.search.map_elites import MapElites, Variation
from jaxwalk.search.methods import Generation

PARENT = 10**6
"""The parent's key: ordinary candidates have smaller ones."""


def only_elite(point):
    """Return elites of one failure."""
    cell = CELLS - 1
    visits = np.bincount([cell], minlength=CELLS)
    return Elites(np.array([cell]), np.array([50.0]), Candidates(point[None], np.array([PARENT])), visits)


def played(street, points):
    """Return all that a scenario chooses, a row for each point."""
    leaves = jax.tree.leaves(scenarios_at(street, points))
    return np.concatenate([np.asarray(leaf, np.float64).reshape(-1, len(points)) for leaf in leaves]).T


@pytest.mark.parametrize("edge", [None, EDGE, 1 - EDGE])
def test_no_child_is_its_parents_copy(game, edge):
    """Also at the edges of the cube, where a step outwards is clipped away."""
    rng = np.random.default_rng(0)
    own = ordinary(rng, 1, game.dimensions)[0] if edge is None else np.full(game.dimensions, edge, np.float32)
    method = MapElites(game.street)
    found = method.ask(method.begin(game.dimensions), only_elite(own), Generation(rng, 1, 512))
    children = found.points[found.keys == PARENT]
    assert 400 < len(children) < 512
    parent = played(game.street, own[None])
    assert (played(game.street, children) != parent).any(axis=1).all()


def test_a_child_steps_in_at_least_one_group():
    way = Variation(np.array([-1, 0, 0, 1, -1, 2]), (1e-9,), (0.0,))
    points = np.full((300, 6), 0.5, np.float32)
    moved = way.children(np.random.default_rng(0), points) != points
    assert (moved[:, 1] == moved[:, 2]).all() and not moved[:, [0, 4]].any()
    assert (moved[:, [1, 3, 5]].sum(axis=1) == 1).all()
    assert moved[:, [1, 3, 5]].any(axis=0).all()
