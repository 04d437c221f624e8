"""Scenes for shields, made by hand: a car on the paper's street with people around it, and a straight road."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from jaxwalk import Street
from jaxwalk.interfaces import Moment
from jaxwalk.policies import RouteFollower
from jaxwalk.policies.shielding import Shielded
from jaxwalk.policies.shields.shield_scene import Around
from jaxwalk.safety.bicycle import slip
from jaxwalk.sim.events import to_rectangle
from jaxwalk.sim.geometry import to_frame
from jaxwalk.sim.prediction import AWAY
from jaxwalk.sim.sim_config import WORLDS
from jaxwalk.sim.state import Motion

STREET = Street.create(config=WORLDS["paper-footprint"])
RULES = STREET.config
THROTTLE = np.array([1.0, 0.0], np.float32)
PEOPLE, BATCH = 7, 64
"""All scenes are of one shape, so that one program judges them; who isn't needed is away, so nobody perceives them."""


def scenes(speed, people, steering=0.0):
    """A batch of scenes at the start of a route. ``people``: ahead, left and velocities, ``(4, ped, episode)``."""
    everybody = np.zeros((4, PEOPLE, BATCH), np.float32)
    everybody[0] = AWAY
    everybody[:, : np.shape(people)[1]] = people
    return _scenes(np.float32(speed), everybody, np.float32(steering))


@jax.jit
def _scenes(speed, people, steering):
    batch = people.shape[2:]
    scenario = jax.vmap(STREET.draw, out_axes=-1)(jax.random.split(jax.random.key(7), 1))
    scenario = jax.tree.map(lambda x: jnp.broadcast_to(x, (*x.shape[:-1], *batch)), scenario)
    scene = Around()(Moment(STREET.world, scenario, STREET.reset(scenario)))
    full = {"speed": speed, "steering": steering}
    car = replace(scene.car, **{name: jnp.broadcast_to(jnp.float32(x), batch) for name, x in full.items()})
    return replace(scene, car=car, people=Motion(*jnp.asarray(people)))


@eqx.filter_jit
def judge(shield, action, scene):
    """What a shield says."""
    return shield.judge(action, scene)


class Says:
    """A driver that says what it is told."""

    def __init__(self, action):
        self.action, self.view = jnp.asarray(action), RouteFollower().view

    def init(self, agents, batch):
        return None

    def act(self, key, memory, seen):
        return self.action, memory


class Found:
    """A shield that says what another one has found."""

    def __init__(self, verdict):
        self.verdict, self.view = verdict, Around()

    def judge(self, action, scene):
        return self.verdict


def decide(shield, action, scene):
    """What a shielded driver does, its memory, and what is recorded."""
    return Shielded(Says(action), shield).decide(jax.random.split(jax.random.key(0), BATCH), None, (None, scene))


@eqx.filter_jit
def decide_on(verdict, action, scene):
    """The same, after this verdict: one program for all shields."""
    return decide(Found(verdict), action, scene)


def judge_one(shield, action, scene):
    """What a shield says of the first episode, if the car does the same in all of them."""
    verdict = judge(shield, np.tile(np.float32(action)[:, None], BATCH), scene)
    return jax.tree.map(lambda x: np.asarray(x)[..., 0], verdict)


def alone(*person, speed, action=THROTTLE, shield):
    """What a shield says with one person around: ``person`` is ahead, left and velocities."""
    return judge_one(shield, action, scenes(speed, np.reshape(person, (4, 1, 1))))


def drive_past(shield, walk, *, speed, seconds=8.0):
    """Whether a car at full throttle on a straight road without end touches somebody while it moves.

    ``walk(t, (x, y))`` returns place and velocity of the person at a time [s], with the car's centre there.
    """
    x = y = heading = delta = 0.0
    for step in range(round(seconds / RULES.dt)):
        (px, py), (vx, vy) = walk(step * RULES.dt, (x, y))
        cos, sin = np.cos(heading), np.sin(heading)
        place = to_frame(px - x, py - y, cos, sin)
        if speed >= RULES.moving_speed and to_rectangle(*place, RULES.car_length, RULES.car_width) < RULES.body_radius:
            return True
        action = THROTTLE
        if shield:
            person = np.reshape([*place, *to_frame(vx, vy, cos, sin)], (4, 1, 1))
            verdict = judge_one(shield, action, scenes(speed, person, delta))
            action = action if verdict.safe else verdict.instead
        speed = float(np.clip(speed + 3.0 * action[0] * RULES.dt, 0, RULES.max_speed))
        delta = RULES.max_steering * float(action[1])
        cos_slip, sin_slip = (float(v) for v in slip(jnp.float32(delta)))
        x += speed * RULES.dt * (cos * cos_slip - sin * sin_slip)
        y += speed * RULES.dt * (sin * cos_slip + cos * sin_slip)
        heading += speed * RULES.dt * sin_slip / (0.5 * RULES.wheelbase)
    return False
