"""Nothing that is seen lies outside the bounds that are claimed for it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.sim.observation import OBSERVATIONS, ROUNDING, bounds, part
from sim.play import SETS, everything, random_actions


def of(street, role, name):
    return bounds(street.world, role, name)


def test_observations_of_random_driving_lie_within_their_bounds(paid_street, scenarios, midway):
    drive, go = random_actions(3)
    state, seen = midway, None
    lowest, highest = ({name: [] for name in SETS} for _ in range(2))
    for step in range(60):
        chosen = {"driver": jnp.asarray(drive[step]), "pedestrian": jnp.asarray(go[step])}
        state, _, seen, _ = everything(paid_street, scenarios, state, chosen)
        for role, name in SETS:
            x = np.asarray(seen[f"{role} {name}"]).reshape(len(seen[f"{role} {name}"]), -1)
            lowest[role, name].append(x.min(axis=1))
            highest[role, name].append(x.max(axis=1))
    outside = []
    for role, name in SETS:
        low, high = of(paid_street, role, name)
        least, most = np.min(lowest[role, name], axis=0), np.max(highest[role, name], axis=0)
        outside += [(role, name, int(i)) for i in np.flatnonzero((least < low) | (most > high))]
    assert outside == []


def test_bounds_are_those_of_the_rules(street):
    low, high = of(street, "driver", "route")
    assert (low[part("driver", "route", "speed")], high[part("driver", "route", "speed")]) == pytest.approx(
        (-ROUNDING, 1 + ROUNDING)
    )
    first = part("driver", "route", "route").start  # 2.5 m ahead, which is the scale
    diagonal = float(np.hypot(street.world.maps.width[0], street.world.maps.height[0]))
    assert high[first] == pytest.approx(diagonal / 2.5 + ROUNDING)
    low, high = of(street, "pedestrian", "kerb")
    place = part("pedestrian", "kerb", "to_kerb")
    assert (low[place], high[place]) == pytest.approx((-1 - ROUNDING, 1.5 + ROUNDING))
    pace = part("pedestrian", "kerb", "pace")
    assert (low[pace], high[pace]) == pytest.approx((0.5 - ROUNDING, 1 + ROUNDING))


@pytest.mark.parametrize(("role", "name"), [(role, name) for role, sets in OBSERVATIONS.items() for name in sets])
def test_every_set_has_a_bound_for_each_feature(street, role, name):
    low, high = of(street, role, name)
    scenario = jax.eval_shape(street.draw, jax.random.key(0))
    seen = jax.eval_shape(lambda s: street.observe(s, street.reset(s), street.view(role, name)), scenario)
    assert low.shape == high.shape == seen.shape[:1]
    assert np.isfinite(low).all() and np.isfinite(high).all() and (low < high).all()


def test_an_unknown_set_is_refused(street):
    with pytest.raises(ValueError, match="no observation set 'lidar' for the driver; there are: paper, route"):
        of(street, "driver", "lidar")
