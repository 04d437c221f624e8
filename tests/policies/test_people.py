"""People of many kinds at a kerb, on observations made by hand."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.policies import POPULATIONS
from jaxwalk.policies.diffusion import Diffusion, acceleration
from jaxwalk.policies.distracted import Distracted
from jaxwalk.policies.gap_acceptance import GapAccepting
from jaxwalk.policies.kerb_gap import kerb_gap
from jaxwalk.policies.pedsumo import PHONES, PedSumo, chance, group_sizes
from jaxwalk.sim.features import SPEED
from jaxwalk.sim.observation import part, size
from jaxwalk.sim.pedestrian_features import KERB_CAR_DISTANCE

PEOPLE = 4000
DT = 0.1


@eqx.filter_jit
def kerb(ahead, speed, *, deciding=True, people=PEOPLE):
    """What people at a kerb see of a car [m, m/s], all alike, in an episode."""
    seen = jnp.zeros((size("pedestrian", "kerb"), people, 1))
    seen = seen.at[part("pedestrian", "kerb", "decides")].set(deciding)
    seen = seen.at[part("pedestrian", "kerb", "place").start].set(ahead / KERB_CAR_DISTANCE)
    return seen.at[part("pedestrian", "kerb", "car_motion").start].set(speed / SPEED)


@eqx.filter_jit
def arrived(policy, ahead=60.0, speed=8.0):
    """Return the memory of people who are about to arrive at the kerb."""
    memory = policy.init((PEOPLE,), (1,))
    return policy.act(jax.random.split(jax.random.key(9), 1), memory, kerb(ahead, speed, deciding=False))[1]


@eqx.filter_jit
def starts(policy, memory, ahead, speed):
    """Return in which step each pedestrian starts (the number of steps: in none), and who goes by step."""

    def step(memory, now):
        key, ahead, speed = now
        go, memory = policy.act(key[None], memory, kerb(ahead, speed))
        return memory, go[:, 0] > 0

    keys = jax.random.split(jax.random.key(1), len(ahead))
    went = jax.lax.scan(step, memory, (keys, ahead, speed))[1]
    return jnp.where(went.any(axis=0), went.argmax(axis=0), len(ahead)), went


def constant(seconds, speed):
    """Return distances and speeds, by step, of a car that arrives after some seconds."""
    time = seconds - DT * np.arange(round(seconds / DT))
    return jnp.asarray(time * speed), jnp.full(len(time), speed)


@pytest.mark.parametrize(
    ("kmh", "seconds", "share"),
    [(30, 2, 0.02), (30, 3, 0.06), (30, 4, 0.21), (30, 5, 0.45), (30, 6, 0.69), (30, 8, 0.92), (50, 4, 0.47)],
)
def test_diffusion_crosses_before_the_car_as_often_as_its_source(kmh, seconds, share):
    ahead, speed = constant(seconds, kmh / 3.6)
    start, _ = starts(Diffusion(), arrived(Diffusion(), ahead[0], speed[0]), ahead, speed)
    assert (start < len(ahead)).mean() == pytest.approx(share, abs=0.03)


@pytest.mark.parametrize("kind", [Diffusion(), Distracted()])
def test_who_has_started_goes_on(kind):
    _, went = starts(kind, arrived(kind), *constant(5.0, 8.0))
    assert 0.2 < went[-1].mean() < 0.8
    assert (went[1:] >= went[:-1]).all()


@pytest.mark.parametrize(("ahead", "speed"), [(5.0, 0.2), (-1.5, 8.0)])
def test_a_car_that_stands_or_has_passed_lets_people_go(ahead, speed):
    steps = 40
    start, _ = starts(Diffusion(), arrived(Diffusion(), ahead, speed), jnp.full(steps, ahead), jnp.full(steps, speed))
    assert (start < steps).mean() > 0.9
    assert start.mean() * DT > 0.3  # it takes time to see that, too


def test_a_car_that_brakes_is_let_pass_less_often():
    time = DT * np.arange(20)
    held = jnp.asarray(25 - 8 * time), jnp.full(20, 8.0)
    braking = jnp.asarray(25 - 8 * time + 1.5 * time**2), jnp.asarray(8 - 3 * time)
    memory = arrived(Diffusion(), 25.8, 8.0)
    go_on, yielded = (starts(Diffusion(), memory, *course)[0] < 20 for course in (held, braking))
    assert yielded.mean() > go_on.mean() + 0.3
    by_hand = acceleration(memory, jnp.full((PEOPLE, 1), 7.7), DT)
    np.testing.assert_allclose(by_hand, -3.0, atol=1e-3)


def test_distracted_people_start_later_and_into_shorter_gaps():
    ahead, speed = constant(5.0, 8.0)
    usual, late = (starts(kind, arrived(kind, 40.8), ahead, speed)[0] for kind in (Diffusion(), Distracted()))
    left = [5.0 - DT * start[start < len(ahead)] for start in (usual, late)]
    assert late.min() * DT >= 1.0 - DT
    assert left[1].mean() < left[0].mean() - 0.2
    assert (left[1] < 3.2).mean() > (left[0] < 3.2).mean() + 0.1


def test_distracted_people_judge_by_what_they_saw_on_arrival():
    far, near = jnp.full(25, 60.0), jnp.full(25, 3.0)
    fast = jnp.full(25, 8.0)
    trusting, _ = starts(Distracted(), arrived(Distracted(), 60.0), near, fast)
    wary, _ = starts(Distracted(), arrived(Distracted(), 3.0), far, fast)
    assert (trusting < 25).mean() > 0.4  # the car is 0.4 s away
    assert (wary <= 10).mean() < 0.02


def test_half_of_gaps_of_6_6_seconds_are_accepted():
    critical = arrived(GapAccepting())
    go, _ = GapAccepting().act(jax.random.split(jax.random.key(0), 1), critical, kerb(6.6 * 8, 8.0))
    assert go.mean() == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("name", POPULATIONS)
def test_whoever_has_nothing_to_decide_goes(name):
    policy = POPULATIONS[name]()
    seen = kerb(1.0, 8.0, deciding=False) if policy.view.name == "kerb" else jnp.zeros((20, PEOPLE, 1))
    go, _ = policy.act(jax.random.split(jax.random.key(0), 1), policy.init((PEOPLE,), (1,)), seen)
    assert go.all()


@pytest.mark.parametrize(
    ("seconds", "group", "phone", "waited", "expected"),
    [
        (0.9, 1, False, 0, 0.4 * 0.01),
        (2.9, 1, False, 0, 0.4 * 0.1),
        (4.5, 1, False, 0, 0.4 * 1.1),
        (4.5, 1, True, 28, 0.4 * 1.1 * 1.5),
        (2.9, 2, False, 0, 0.4 * 0.1 * 1.2),
        (2.9, 4, False, 0, 0.4 * 0.1 * 1.4),
        (2.9, 3, True, 38, 0.4 * 0.1 * 1.2 * 1.5 * 1.494),
        (6.0, 1, False, 0, 0.4 * 3),
    ],
)
def test_pedsumo_multiplies_its_factors(seconds, group, phone, waited, expected):
    gap = eqx.filter_jit(kerb_gap)(kerb(jnp.float32(8 * seconds), jnp.float32(8), people=1))
    whole = jnp.ones((1, 1))
    found = eqx.filter_jit(chance)(gap, whole * group, whole * phone > 0, whole * waited)
    assert found.item() == pytest.approx(expected, rel=1e-4)


def test_pedsumo_draws_once_a_second():
    steps, share = 25, 0.4 * 0.1
    _, went = starts(PedSumo(), arrived(PedSumo()), jnp.full(steps, 2.0 * 8), jnp.full(steps, 8.0))
    gone = np.asarray(went.mean(axis=1))
    drew = np.flatnonzero(np.diff(gone, prepend=0) > 0)
    assert drew.tolist() == [0, 10, 20]
    mean = share * 1.4 * (1 - PHONES + PHONES * 1.5)  # everybody stands at one place: a large group
    np.testing.assert_allclose(gone[[0, 10, 20]], 1 - (1 - mean) ** np.arange(1, 4), atol=0.015)


def test_pedsumo_counts_who_decides_nearby():
    seen = kerb(jnp.array([10.0, 12.0, 12.5, 30.0, 10.0])[:, None], 8.0, people=5)
    seen = seen.at[part("pedestrian", "kerb", "decides").start, 4].set(0)
    assert group_sizes(kerb_gap(seen))[:, 0].tolist() == [3, 3, 3, 1, 3]
