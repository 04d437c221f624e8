"""Paths worked out ahead are the ones that people walk, however much they wait."""

from __future__ import annotations

import numpy as np
import pytest

from jaxwalk.sim.walking_paths import walking_paths
from sim.play import columns

EPISODES = 8


@pytest.fixture(scope="module")
def paths(street, scenarios):
    return walking_paths(street.world, columns(scenarios, slice(EPISODES)), reach=100.0)


def along(x, y):
    """Metres of a polyline up to each of its points."""
    return np.concatenate([[0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])


def test_paths_are_as_long_as_asked_for(paths):
    lengths = np.hypot(np.diff(paths.x, axis=0), np.diff(paths.y, axis=0)).sum(axis=0)
    assert lengths.shape == (12, EPISODES)
    assert lengths.min() >= 100


def test_whoever_always_goes_walks_the_path_at_one_speed(paths, always_go, street, scenarios):
    speed = np.asarray(scenarios.walking_speed(street.world))
    people = always_go
    for ped, e in ((0, 0), (5, 3), (11, 7)):
        x, y = paths.x[:, ped, e], paths.y[:, ped, e]
        walked = np.arange(501) * 0.1 * speed[ped, e]
        metres = along(x, y)
        expected = np.interp(walked, metres, x), np.interp(walked, metres, y)
        np.testing.assert_allclose(people["x"][:, ped, e], expected[0], atol=2e-2)
        np.testing.assert_allclose(people["y"][:, ped, e], expected[1], atol=2e-2)


def test_waiting_changes_no_path(paths, driven):
    _, frames = driven
    people = frames
    for ped, e in ((2, 1), (7, 4)):
        x, y = paths.x[:, ped, e], paths.y[:, ped, e]
        dense = np.linspace(0, along(x, y)[-1], 20_000)
        points = np.stack([np.interp(dense, along(x, y), x), np.interp(dense, along(x, y), y)])
        for frame in range(0, 501, 50):
            here = np.array([people["x"][frame, ped, e], people["y"][frame, ped, e]])[:, None]
            assert np.hypot(*(points - here)).min() < 0.02


def test_jaywalks_and_goals_are_marked(paths, always_go):
    people = always_go
    assert (np.diff(paths.arrivals, axis=0) >= 0).all()
    assert paths.arrivals[0].max() == 0
    jaywalked = ((people["crossing"] == 2) & people["on_roadway"]).any(axis=0)[:, :EPISODES]
    assert jaywalked.any()
    assert (paths.jaywalk.any(axis=0) | ~jaywalked).all()
