"""Where nobody may jaywalk, using the crosswalk tells nothing about a tendency, and nothing is decided."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk import SimConfig, Street
from jaxwalk.maps import MapText
from jaxwalk.maps.network import Area, Crossing
from jaxwalk.maps.network_file import network_text
from jaxwalk.sim import belief
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from maps.networks import CENTRE, PIECES, RADIUS, arc, bend, ring
from sim.passersby import drawn

BATCH, PEOPLE = 32, 6
WITHOUT = (2, 3)
"""The sides of the second crosswalk."""


def bend_with_two_crosswalks():
    """The bend with another crosswalk beyond the end of the zone, which has none."""
    street, half = bend(), 2 / RADIUS
    each = (len(street.walk.nodes) - 1) // 2
    near, far, middle = PIECES + 3, each + PIECES + 3, len(street.walk.nodes)
    angle = np.arctan2(*(street.walk.nodes[near] - CENTRE)[::-1])
    walk = replace(
        street.walk,
        nodes=np.concatenate([street.walk.nodes, arc(RADIUS, angle, angle)[:1]]),
        edges=np.concatenate([street.walk.edges, [(near, middle), (middle, far)]]),
    )
    return replace(
        street,
        areas=(*street.areas, Area("crosswalk", ring(46, 54, angle - half, angle + half))),
        walk=walk,
        crossings=(*street.crossings, Crossing("zebra", (len(street.areas),), (near, middle, far))),
    )


@eqx.filter_jit
def walked(street, scenarios):
    """Everybody walks while the car stands: after each step, what is counted, who is on the roadway, and why."""
    actions = {"driver": jnp.stack([-jnp.ones(BATCH), jnp.zeros(BATCH)]), "pedestrian": jnp.ones((PEOPLE, BATCH), int)}

    def step(state, _):
        state, _ = street.step(scenarios, state, actions)
        people, seen = state.pedestrian, state.perceived.crossings
        counted = jnp.stack(belief.crossings_seen(street.world, scenarios, people))
        perceived = jnp.stack([seen.jaywalks, seen.crosswalks])
        return state, (counted, perceived, people.on_roadway, people.crossing, people.leg.side, people.decisions)

    return jax.lax.scan(step, street.reset(scenarios), None, street.world.rules.horizon)[1]


@pytest.fixture(scope="module")
def steps():
    rules = SimConfig(horizon=500, pedestrians=PEOPLE, perception=True, sight=1000.0)
    text = MapText.of("two.json", network_text(bend_with_two_crosswalks()))
    street = Street.create([text], rules, jaywalk_multiplier=1.0)
    return jax.tree.map(np.asarray, walked(street, drawn(street, BATCH)))


def test_only_crossings_beside_a_zone_count(steps):
    """Against the frames: rising edges of being on the roadway, by kind and by side."""
    counted, perceived, on_roadway, crossing, side, _ = steps
    enters = on_roadway & ~np.concatenate([on_roadway[:1], on_roadway[:-1]])
    free = ~np.isin(side, WITHOUT)
    assert (enters & ~free).sum() > 20 and (crossing[enters & ~free] == CROSSWALK).all()
    for kind, found, seen in zip((JAYWALK, CROSSWALK), *(x.swapaxes(0, 1) for x in (counted, perceived)), strict=True):
        expected = np.cumsum(enters & free & (crossing == kind), axis=0)
        assert expected[-1].sum() > 20
        np.testing.assert_array_equal(found, expected)
        np.testing.assert_array_equal(seen, expected)


def test_nothing_is_decided_without_a_zone(steps):
    *_, side, decisions = steps
    made = np.diff(decisions, axis=0) > 0
    assert made.any()
    assert not np.isin(side[1:][made], WITHOUT).any()
