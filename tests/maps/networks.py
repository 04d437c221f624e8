"""Networks for tests: a street along an arc, one with an island, and any street turned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jaxwalk.maps.network import Area, Crossing, JaywalkZone, Lane, LaneRoute, Network, WalkGraph, corners

CENTRE, RADIUS, SIZE = np.array([-30.0, 45.0]), 50.0, (30.0, 90.0)
"""The street's middle is an arc of 50 m about this point, from 45 degrees right of east to 45 degrees left."""
FIRST, LAST, CROSSWALK, PIECES = -np.pi / 4, np.pi / 4, -0.5, 16
"""Angles where the street begins and ends and of its crosswalk's middle [rad]; pieces of its jaywalk zone."""


def arc(radius, first, last, spacing=0.01):
    """Points of an arc about `CENTRE`, with one about every ``spacing`` rad."""
    angle = np.linspace(first, last, max(2, int(np.ceil(abs(last - first) / spacing)) + 1))
    return CENTRE + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def ring(inner, outer, first, last):
    """Outline of a piece of a ring."""
    return np.concatenate([arc(outer, first, last), arc(inner, last, first)])


def bend():
    """A street of 8 m with sidewalks of 2 m along the arc: two lanes, a crosswalk and a jaywalk zone to its left."""
    ends = [FIRST + 0.02, LAST - 0.02]
    places = [ends[0], *np.linspace(CROSSWALK, 0.3, PIECES + 1), *np.linspace(0.3, ends[1], 5)[1:]]
    sides = [np.concatenate([arc(radius, angle, angle)[:1] for angle in places]) for radius in (45, 55)]
    each = len(places)
    edges = [(side * each + n, side * each + n + 1) for side in (0, 1) for n in range(each - 1)]
    landing, middle = (1, each + 1), 2 * each
    zone = (tuple(range(1, PIECES + 2)), tuple(range(each + 1, each + PIECES + 2)))
    half = 2 / RADIUS
    return Network(
        size=SIZE,
        lanes=(
            Lane(line=arc(52, FIRST, LAST), width=4, speed_limit=8.33),
            Lane(line=arc(48, LAST, FIRST), width=4, speed_limit=8.33),
        ),
        areas=(
            Area(kind="roadway", outline=ring(46, 54, FIRST, LAST)),
            Area(kind="sidewalk", outline=ring(44, 46, FIRST, LAST)),
            Area(kind="sidewalk", outline=ring(54, 56, FIRST, LAST)),
            Area(kind="crosswalk", outline=ring(46, 54, CROSSWALK - half, CROSSWALK + half)),
        ),
        walk=WalkGraph(
            nodes=np.concatenate([*sides, arc(50, CROSSWALK, CROSSWALK)[:1]]),
            edges=np.array([*edges, (landing[0], middle), (middle, landing[1])]),
            waypoints=2 * each,
        ),
        crossings=(
            Crossing(
                kind="zebra",
                areas=(3,),
                nodes=(landing[0], middle, landing[1]),
                zone=JaywalkZone(sides=zone, begin=3.0, end=27.0),
            ),
        ),
        routes=(LaneRoute(lanes=(0,), start=5.0, goal=70.0), LaneRoute(lanes=(1,), start=5.0, goal=65.0)),
    )


def moved(network, change, size):
    """The network with every point changed."""
    return replace(
        network,
        size=size,
        lanes=tuple(replace(lane, line=change(lane.line)) for lane in network.lanes),
        areas=tuple(
            replace(area, outline=change(area.outline), holes=tuple(change(hole) for hole in area.holes))
            for area in network.areas
        ),
        walk=replace(network.walk, nodes=change(network.walk.nodes)),
    )


def turned(network, angle):
    """The network turned to the left about its middle by an angle [rad], and how points turn."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    size = np.abs(turn) @ network.size
    middle = np.array(network.size) / 2

    def change(points):
        return (np.asarray(points) - middle) @ turn.T + size / 2

    return moved(network, change, tuple(size)), change


def island():
    """A straight street of 12 m with an island in its middle, and a crossing over it without a jaywalk zone."""
    x, ends = (1, 30, 59), (3.0, 21.0)
    nodes = [(at, y) for y in ends for at in x]
    middles = [(30, 7.5), (30, 12), (30, 16.5)]
    return Network(
        size=(60, 24),
        lanes=(
            Lane([[0, 7], [60, 7]], 4, 8.33),
            Lane([[60, 17], [0, 17]], 4, 8.33),
        ),
        areas=(
            Area("roadway", corners((0.0, 5.0, 60.0, 19.0)), (corners((26.0, 10.0, 34.0, 14.0)),)),
            Area("island", corners((26.0, 10.0, 34.0, 14.0))),
            Area("sidewalk", corners((0.0, 1.0, 60.0, 5.0))),
            Area("sidewalk", corners((0.0, 19.0, 60.0, 23.0))),
            Area("crosswalk", corners((28.0, 5.0, 32.0, 10.0))),
            Area("crosswalk", corners((28.0, 14.0, 32.0, 19.0))),
        ),
        walk=WalkGraph(
            np.array([*nodes, *middles], float),
            np.array([(0, 1), (1, 2), (3, 4), (4, 5), (1, 6), (6, 7), (7, 8), (8, 4)]),
            6,
        ),
        crossings=(Crossing("zebra", (4, 5), (1, 6, 7, 8, 4)),),
        routes=(LaneRoute((0,), 5.0, 50.0), LaneRoute((1,), 5.0, 50.0)),
    )
