"""A car that drives at a person on one line, in steps of 0.01 s, as protocols of crash tests have it.

The person crosses at 5 km/h and would be in the middle of the unbraked car's front when it arrives. It is seen from a
time to collision on. Only the way to the person counts: the impact is where the gap is closed, however far the person
has walked by then.
"""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from jaxwalk.policies.careful_human import CarefulHuman
from jaxwalk.safety.stopping import last_moment
from jaxwalk.sim.corridor import BESIDE, NEARING, WATCHED
from jaxwalk.sim.features import SPEED
from jaxwalk.sim.observation import CORRIDOR, part, size
from jaxwalk.sim.prediction import DISTANCE
from jaxwalk.sim.sim_config import SimConfig

DT, SECONDS, PACE = 0.01, 8.0, 5 / 3.6
FRONT = SimConfig.car_length / 2 + SimConfig.body_radius
"""The car's centre is this far from somebody whom its front touches [m]."""
SCALES = (DISTANCE, DISTANCE, SPEED, SPEED, NEARING)
NOBODY = (DISTANCE, BESIDE, 0.0, 0.0, NEARING)


def seen(speed, top, people):
    """What a driver sees with the set "corridor" on a straight route.

    ``people``: along [m], left [m], speed along, speed to the left [m/s], way to a crosswalk [m], a row each.
    """
    rows = [*people, *[NOBODY] * (WATCHED - len(people))]
    shown = jnp.stack(
        [jnp.asarray(x, jnp.float32) / scale for row in rows for x, scale in zip(row, SCALES, strict=True)]
    )
    route = part("driver", CORRIDOR, "route")
    observation = jnp.zeros(size("driver", CORRIDOR)).at[part("driver", CORRIDOR, "watched")].set(shown)
    observation = observation.at[part("driver", CORRIDOR, "speed")].set(speed / SPEED)
    observation = observation.at[part("driver", CORRIDOR, "top_speed")].set(top / SPEED)
    return observation.at[route.start : route.stop : 2].set(1.0)


@eqx.filter_jit
def accelerations(driver, kmh, seen_at, begin=4.0):
    """The speeds [m/s], gaps [m] and accelerations [m/s2] of a run from a time to collision ``begin`` on."""
    top = jnp.float32(kmh / 3.6)

    def step(carry, number):
        speed, gap, memory = carry
        child = gap + FRONT, PACE * (begin - number * DT), 0.0, -PACE, NEARING
        visible = gap <= seen_at * top
        row = [jnp.where(visible, x, away) for x, away in zip(child, NOBODY, strict=True)]
        (pedal, _), memory = driver.act(jax.random.key(0), memory, seen(speed, top, [row]))
        acceleration = pedal * jnp.where(pedal < 0, driver.max_braking, driver.max_acceleration)
        speed = jnp.clip(speed + acceleration * DT, 0, top)
        return (speed, gap - speed * DT, memory), (speed, gap, acceleration)

    start = (top, top * begin, driver.init((), ()))
    return jax.lax.scan(step, start, jnp.arange(round(SECONDS / DT)))[1]


def human(kmh, seen_at, braking):
    """The impact speed of the careful human [km/h]; 0 if it stops in time."""
    driver = CarefulHuman(max_braking=braking, dt=DT)
    return impact(*accelerations(driver, kmh, seen_at))


def impact(speed, gap, _=None):
    """The speed at which the gap is closed [km/h], and 0 if the car stands before, whatever it does then."""
    speed, gap = np.asarray(speed), np.asarray(gap)
    over = (gap <= 0) | (speed <= 0)
    assert over.any()
    return 3.6 * float(speed[np.argmax(over)])


def automatic(kmh, seen_at, braking, spare=0.4, latency=0.1):
    """The impact speed of emergency braking that begins ``spare`` before the last moment [km/h]."""
    speed, gap, brakes_at, time = kmh / 3.6, 4.0 * kmh / 3.6, np.inf, 0.0
    while gap > 0 and speed > 0:
        close = gap <= seen_at * kmh / 3.6 and gap / speed < float(last_moment(jnp.float32(speed), braking, spare))
        brakes_at = min(brakes_at, time + latency) if close else brakes_at
        speed = max(speed - braking * DT * (time >= brakes_at), 0)
        gap, time = gap - speed * DT, time + DT
    return 3.6 * speed
