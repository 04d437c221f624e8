"""Jaywalks that begin a few centimetres away: where legs are shorter than a stride, and goals nearest to each other."""

from __future__ import annotations

import dataclasses

import jax.numpy as jnp
import numpy as np

from sim.play import play


def test_short_legs_make_nobody_faster_and_the_tables_last(street, scenarios):
    everybody = dataclasses.replace(
        scenarios,
        traits=scenarios.traits.at[0].set(1.0).at[1].set(1.0),
        jaywalk_draw=jnp.zeros_like(scenarios.jaywalk_draw),
        zone_draw=jnp.full_like(scenarios.zone_draw, 0.999),
    )
    played = play(street, everybody)
    moved = np.hypot(np.diff(played["x"], axis=0), np.diff(played["y"], axis=0))
    assert moved.max() <= 0.2 + 1e-4
    assert (played["crossing"] == 2).any()
    assert played["arrivals"].max() < len(everybody.goals)
    assert played["decisions"].max() <= len(everybody.jaywalk_draw)
