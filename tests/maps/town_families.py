"""Families of streets with random parameters, for tests."""

from __future__ import annotations

from dataclasses import fields

from hypothesis import strategies as st

from jaxwalk.maps.generated import LAYOUTS, TOWN, UNSEEN, Town
from jaxwalk.maps.generated.town import FASTEST


def hull(name):
    """The smallest and the largest value of a range in both families."""
    ends = [*getattr(TOWN, name), *getattr(UNSEEN, name)]
    return min(ends), max(ends)


def ranges(name):
    low, high = hull(name)
    return st.tuples(st.floats(low, high), st.floats(low, high)).map(lambda pair: tuple(sorted(pair)))


def by_field():
    """A strategy for each parameter."""
    found = {x.name: ranges(x.name) for x in fields(Town) if x.type == "Range"}
    found |= {x.name: st.floats(0, 1) for x in fields(Town) if x.type == "float"}
    found["layouts"] = st.lists(st.sampled_from(LAYOUTS), min_size=1, max_size=6).map(tuple)
    found |= {name: st.lists(st.integers(1, 2), min_size=1, max_size=3).map(tuple) for name in ("lanes", "arm_lanes")}
    found["speed_limits"] = st.lists(st.floats(4, FASTEST), min_size=1, max_size=3).map(tuple)
    return found


FAMILIES = st.one_of(st.just(TOWN), st.just(UNSEEN), st.fixed_dictionaries(by_field()))
"""The two families of the splits, and the parameters of any between and beside them."""
