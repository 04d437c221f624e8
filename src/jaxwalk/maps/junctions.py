"""Where lanes meet, and which of them lie in junctions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
import shapely

from jaxwalk.maps.network import Lane


class LanePlaces(NamedTuple):
    """Places where lanes begin and end: what begins where another lane ends has the same place."""

    begin: np.ndarray
    """Number of the place where each lane begins, int (lane,)."""
    end: np.ndarray
    """Number of the place where it ends, int (lane,)."""

    @classmethod
    def of(cls, lanes: tuple[Lane, ...]) -> LanePlaces:
        """Return the places of lanes."""
        count = len(lanes)
        joined = [(count + one, other) for one, lane in enumerate(lanes) for other in lane.successors]
        place = _components(np.array(joined, int).reshape(-1, 2), 2 * count)
        return cls(place[:count], place[count:])


def in_junction(lanes: tuple[Lane, ...], places: LanePlaces) -> np.ndarray:
    """Return which lanes lie in junctions, bool (lane,): they fork, merge or cross, and join two other lanes."""
    count = 2 * len(lanes)
    begins, ends = (np.bincount(place, minlength=count) for place in places)
    shared = (begins[places.begin] > 1) | (ends[places.end] > 1)
    between = (ends[places.begin] > 0) & (begins[places.end] > 0)
    crossed = np.zeros(len(lanes), bool)
    crossed[_crossings(lanes)[0]] = True
    return (shared | crossed) & between


def junction_of(lanes: tuple[Lane, ...], places: LanePlaces) -> np.ndarray:
    """Return the number of each lane's junction, int (lane,), from 0; -1 for lanes that lie in none."""
    inside = in_junction(lanes, places)
    numbers = np.flatnonzero(inside)
    found = np.full(len(lanes), -1)
    by_place = [(lane, len(lanes) + place[lane]) for place in places for lane in numbers]
    crossed = [pair for pair in _crossings(lanes).T if inside[pair].all()]
    joined = _components(np.array([*by_place, *crossed], int).reshape(-1, 2), 3 * len(lanes))
    found[numbers] = np.unique(joined[numbers], return_inverse=True)[1]
    return found


def _crossings(lanes: tuple[Lane, ...]) -> np.ndarray:
    """Return the pairs of lanes that cross, int (2, pair)."""
    middles = np.array([shapely.LineString(lane.line) for lane in lanes])
    return shapely.STRtree(middles).query(middles, "crosses")


def _components(pairs: np.ndarray, count: int) -> np.ndarray:
    """Return the number of each node's component, int (count,); ``pairs`` are joined."""
    graph = scipy.sparse.coo_array((np.ones(len(pairs)), pairs.T), shape=(count, count))
    return scipy.sparse.csgraph.connected_components(graph, directed=False)[1]
