"""Playing scenarios and writing everything down. Every function is compiled once and used by many tests."""

from __future__ import annotations

from collections import Counter
from functools import partial, wraps

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import device_put

from compiling import FORGOTTEN
from jaxwalk.rollout import draw_batch, environment_keys, seed_key
from jaxwalk.sim import pedestrian, vehicle
from jaxwalk.sim.observation import INFERRED, OBSERVATIONS, PRIVILEGED_SETS
from jaxwalk.sim.prediction import foresee
from jaxwalk.sim.state import State
from pytrees import as_numpy
from quickly import CAN_EMIT_SIMPLY

ENVIRONMENTS, STEPS, PEOPLE = 256, 500, 12
SETS = [(role, name) for role, sets in OBSERVATIONS.items() for name in sets if name not in PRIVILEGED_SETS | INFERRED]
"""But for those that show the future (`test_future.py`), tendencies or a belief about them (`test_belief.py`)."""
TRACES = Counter()
"""How often Python ran through each compiled function, by the shapes it was called with."""
AS_SHIPPED = {"xla_backend_optimization_level": 3, "xla_llvm_disable_expensive_passes": False}
if CAN_EMIT_SIMPLY:
    AS_SHIPPED["xla_cpu_use_fusion_emitters"] = True
"""How users' programs are compiled: for what is called often, and what is compared with recorded numbers."""


def compiled(function):
    """The function as one program, which gives NumPy arrays: each operation by itself would be a program, too."""
    program = eqx.filter_jit(function)

    @wraps(function)
    def run(*arguments, **options):
        return as_numpy(program(*arguments, **options))

    return run


goal = compiled(vehicle.goal)


def draw(street, seed, domain, first, count=ENVIRONMENTS):
    """Scenarios for the global indices first .. first + count - 1."""
    return _draw(street, environment_keys(seed_key(seed, domain), first, count))


def play(street, scenario, drive=None, go=None, state=None):
    """Frames (frame, ..., env) of 500 steps by name, frame 0 the start, as NumPy arrays.

    ``drive`` is (step, 2, env), default: stand; ``go`` is (step, ped, env), default: always.
    """
    if drive is None:
        drive = np.zeros((STEPS, 2, ENVIRONMENTS), np.float32) - np.array([[1], [0]], np.float32)
    if go is None:
        go = np.ones((STEPS, PEOPLE, ENVIRONMENTS), np.int32)
    state = reset(street, scenario) if state is None else state
    return as_numpy(_play(street, scenario, state, {"driver": drive, "pedestrian": go}))


def random_actions(seed):
    """Uniform accelerations and steering; people go 2 of 3 times."""
    random = np.random.default_rng(seed)
    drive = random.uniform(-1, 1, (STEPS, 2, ENVIRONMENTS)).astype(np.float32)
    drive[:, 0] += 0.3  # so that it gets somewhere
    go = (random.random((STEPS, PEOPLE, ENVIRONMENTS)) < 2 / 3).astype(np.int32)
    return np.clip(drive, -1, 1), go


@jax.jit
def reset(street, scenario):
    return street.reset(scenario)


@jax.jit
def refreshed(street, scenario, state):
    """The state after somebody was moved by hand: with the car's route at ``along``, and what it sees and predicts."""
    course = vehicle.course(street.world, scenario, state.vehicle.along)
    car = eqx.tree_at(lambda car: car.course, state.vehicle, course)
    return State(state.step, car, state.pedestrian, foresee(street.world, scenario, car, state.pedestrian))


def view(street, scenario, state):
    """What tests look at, by name."""
    car, people = state.vehicle, state.pedestrian
    vx, vy = pedestrian.velocity(street.world, scenario, people)
    return {
        "step": state.step, "car_x": car.x, "car_y": car.y, "car_cos": car.cos, "car_sin": car.sin,
        "car_speed": car.speed, "car_steering": car.steering, "car_acceleration": car.acceleration,
        "along": car.along, "x": people.x, "y": people.y, "vx": vx, "vy": vy, "on_roadway": people.on_roadway,
        "on_crosswalk": people.on_crosswalk, "crossing": people.crossing, "decisions": people.decisions,
        "goal": people.goal, "arrivals": people.arrivals, "going": people.going,
        "at_kerb": pedestrian.at_kerb(street.world, people),
    }  # fmt: skip


def columns(tree, which):
    """Some environments of a batch."""
    return jax.tree.map(lambda x: device_put(np.asarray(x)[..., which]), tree)  # `jnp.asarray` compiles a program


def alike(tree, which):
    """One environment of a batch, as often as a batch has room for."""
    return columns(tree, np.full(ENVIRONMENTS, which))


def people(scenario, state, order):
    """The same episode with its people in another order (or some left out, or doubled)."""
    order = np.asarray(order)

    def which(s):
        return s.traits, s.goals, s.jaywalk_draw, s.zone_draw

    chosen = eqx.tree_at(which, scenario, [device_put(np.asarray(x)[:, order]) for x in which(scenario)])
    chosen = eqx.tree_at(lambda s: s.start, chosen, device_put(np.asarray(scenario.start)[order]))
    return chosen, eqx.tree_at(
        lambda s: s.pedestrian, state, jax.tree.map(lambda x: device_put(np.asarray(x)[order]), state.pedestrian)
    )


def with_car(state, **values):
    """The state with some of the car's numbers replaced."""
    car = eqx.tree_at(
        lambda c: [getattr(c, name) for name in values],
        state.vehicle,
        [device_put(np.broadcast_to(np.asarray(v, np.float32), state.vehicle.x.shape)) for v in values.values()],
    )
    return eqx.tree_at(lambda s: s.vehicle, state, car)


@jax.jit
def _draw(street, keys):
    return draw_batch(street, keys)


@partial(jax.jit, compiler_options=AS_SHIPPED)
def _play(street, scenario, state, actions):
    TRACES["play", len(FORGOTTEN), state.step.shape, street.world.maps.edges.shape] += 1

    def body(state, action):
        after, _ = street.step(scenario, state, action)
        return after, view(street, scenario, after)

    first = view(street, scenario, state)
    _, frames = jax.lax.scan(body, state, actions)
    return {name: jnp.concatenate([first[name][None], frames[name]]) for name in first}


def _everything(street, scenario, state, actions):
    TRACES["everything", len(FORGOTTEN), state.step.shape, street.world.maps.edges.shape] += 1
    state = refreshed(street, scenario, state)
    seen = {f"{role} {name}": street.observe(scenario, state, street.view(role, name)) for role, name in SETS}
    seen["global"] = street.global_state(scenario, state)
    after, outcome = street.step(scenario, state, actions)
    return after, outcome, seen, view(street, scenario, after)


everything = jax.jit(_everything, compiler_options=AS_SHIPPED | {"xla_llvm_disable_expensive_passes": True})
"""Observations of a state by role and name, then one step: (state, outcome, observations, view of the state)."""

everything_once = jax.jit(_everything)  # called only a few times


def actions(drive=(-1.0, 0.0), go=1, *, shape=(ENVIRONMENTS,), people=PEOPLE):
    """The same actions everywhere, or given arrays."""
    drive, go = np.asarray(drive, np.float32), np.asarray(go, np.int32)
    drive, go = (x.reshape(x.shape + (1,) * (1 + len(shape) - x.ndim)) for x in (drive, go))
    return {
        "driver": device_put(np.broadcast_to(drive, (2, *shape))),
        "pedestrian": device_put(np.broadcast_to(go, (people, *shape))),
    }


def inside(rectangles, x, y, *, margin=0.0):
    """Whether points lie in any rectangle (n, 4), drawn in by ``margin`` (negative: widened)."""
    x0, y0, x1, y1 = (np.asarray(rectangles)[:, i].reshape(-1, *(1,) * np.ndim(x)) for i in range(4))
    within = (x >= x0 + margin) & (x <= x1 - margin) & (y >= y0 + margin) & (y <= y1 - margin)
    return within.any(axis=0)
