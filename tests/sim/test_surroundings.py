"""The set for drivers from elsewhere: edges are where rays meet them, and nothing tells where on the map the car is."""

from __future__ import annotations

import equinox as eqx
import jax
import numpy as np
import pytest
import shapely

from jaxwalk import Street
from jaxwalk.maps import MapText, load_network
from jaxwalk.maps.network_file import network_text
from jaxwalk.sim.observation import part, size
from jaxwalk.sim.prediction import DISTANCE
from jaxwalk.sim.surroundings import RANGE, RAYS
from maps.networks import bend, turned
from sim.play import ENVIRONMENTS, draw, refreshed, reset

NAME = "surroundings"
ANGLE = 0.7


def seen(street, scenario, state):
    look = jax.jit(lambda street: street.observe(scenario, state, street.view("driver", NAME)))
    return np.asarray(look(street))


def of(observation, feature):
    return observation[part("driver", NAME, feature)]


def standing_anywhere(street, scenario, roadway):
    """Cars at random places on a roadway, turned anyhow; returns the state, places (env, 2) and headings."""
    random = np.random.default_rng(0)
    x0, y0, x1, y1 = roadway.bounds
    points = random.uniform((x0, y0), (x1, y1), (20 * ENVIRONMENTS, 2))
    points = points[shapely.contains_xy(roadway.buffer(-0.5), points)][:ENVIRONMENTS].astype(np.float32)
    heading = random.uniform(-np.pi, np.pi, ENVIRONMENTS)
    moved = (*points.T, np.cos(heading, dtype=np.float32), np.sin(heading, dtype=np.float32))
    state = eqx.tree_at(
        lambda s: [getattr(s.vehicle, name) for name in ("x", "y", "cos", "sin")], reset(street, scenario), list(moved)
    )
    return refreshed(street, scenario, state), points.astype(float), heading


def exact_edges(roadway, points, heading):
    """How far each ray goes until it leaves the roadway (ray, env) [m]."""
    angles = heading + 2 * np.pi / RAYS * np.arange(RAYS)[:, None]
    ends = points + RANGE * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    rays = shapely.linestrings(np.stack([np.broadcast_to(points, ends.shape), ends], axis=-2))
    met = shapely.intersection(rays, roadway.boundary)
    return np.minimum(np.where(shapely.is_empty(met), RANGE, shapely.distance(shapely.points(points), met)), RANGE)


def test_the_papers_edges_are_where_rays_meet_them(street, scenarios):
    roadway = load_network("paper").surface("roadway")
    state, points, heading = standing_anywhere(street, scenarios, roadway)
    error = np.abs(RANGE * of(seen(street, scenarios, state), "edges") - exact_edges(roadway, points, heading))
    assert error.shape == (RAYS, ENVIRONMENTS)
    assert (error < 0.03).mean() > 0.99, "but for corners that a ray grazes"
    assert np.median(error) < 1e-3


@pytest.fixture(scope="module")
def bent():
    street = Street.create([MapText.of("bend.json", network_text(bend()))])
    return street, draw(street, 3, 0, 0)


def test_edges_on_a_bend(bent):
    street, scenario = bent
    roadway = bend().surface("roadway")
    state, points, heading = standing_anywhere(street, scenario, roadway)
    error = np.abs(RANGE * of(seen(street, scenario, state), "edges") - exact_edges(roadway, points, heading))
    assert (error < 0.15).mean() > 0.97
    assert np.median(error) < 0.02


def test_a_turned_street_looks_the_same(bent):
    street, scenario = bent
    other = Street.create([MapText.of("bend.json", network_text(turned(bend(), ANGLE)[0]))])
    same = draw(other, 3, 0, 0)
    one, two = (seen(x, y, reset(x, y)) for x, y in ((street, scenario), (other, same)))
    edges = part("driver", NAME, "edges")
    np.testing.assert_allclose(np.delete(one, edges, axis=0), np.delete(two, edges, axis=0), atol=1e-4)
    assert (np.abs(one[edges] - two[edges]) * RANGE < 0.3).mean() > 0.95


def test_positions_are_in_metres_by_one_factor(street, scenarios):
    found = seen(street, scenarios, reset(street, scenarios))
    assert size("driver", NAME) == 67 == len(found)
    route = DISTANCE * of(found, "route").reshape(-1, 2, ENVIRONMENTS)
    for point, ahead in enumerate((2.5, 5.0)):  # routes begin straight ahead
        np.testing.assert_allclose(route[point], [[ahead] * ENVIRONMENTS, [0] * ENVIRONMENTS], atol=1e-3)
    assert (np.diff(np.hypot(route[:, 0], route[:, 1]), axis=0) > 0).all()
