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
LONGEST = 80
"""Steps for which people are played, however many are looked at: so one program serves all tests of a kind."""


def kerb(ahead, speed, *, deciding=True, people=PEOPLE):
    """What people at a kerb see of a car [m, m/s], all alike, in an episode."""
    return _kerb(np.float32(ahead), np.float32(speed), deciding, people)


@eqx.filter_jit
def _kerb(ahead, speed, deciding, people):
    seen = jnp.zeros((size("pedestrian", "kerb"), people, 1))
    seen = seen.at[part("pedestrian", "kerb", "decides")].set(deciding)
    seen = seen.at[part("pedestrian", "kerb", "place").start].set(ahead / KERB_CAR_DISTANCE)
    return seen.at[part("pedestrian", "kerb", "car_motion").start].set(speed / SPEED)


@eqx.filter_jit
def decided(policy, seed, seen, memory=None):
    """Return what people do, who have just come unless they remember something, and their memory."""
    memory = policy.init((PEOPLE,), (1,)) if memory is None else memory
    return policy.act(jax.random.split(jax.random.key(seed), 1), memory, seen)


def arrived(policy, ahead=60.0, speed=8.0):
    """Return the memory of people who are about to arrive at the kerb."""
    return decided(policy, np.uint32(9), kerb(ahead, speed, deciding=False))[1]


def starts(policy, memory, ahead, speed, longest=LONGEST):
    """Return in which step each pedestrian starts (the number of steps: in none), and who goes by step."""
    steps = len(ahead)
    course = (np.pad(np.float32(x), (0, longest - steps), mode="edge") for x in (ahead, speed))
    went = np.asarray(_went(policy, memory, *course))[:steps]
    return np.where(went.any(axis=0), went.argmax(axis=0), steps), went


@eqx.filter_jit
def _went(policy, memory, ahead, speed):
    def step(memory, now):
        key, ahead, speed = now
        go, memory = policy.act(key[None], memory, _kerb(ahead, speed, True, PEOPLE))
        return memory, go[:, 0] > 0

    keys = jax.random.split(jax.random.key(1), len(ahead))
    return jax.lax.scan(step, memory, (keys, ahead, speed))[1]


def constant(seconds, speed):
    """Return distances and speeds, by step, of a car that arrives after some seconds."""
    time = seconds - DT * np.arange(round(seconds / DT))
    return time * speed, np.full(len(time), speed)


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
    start, _ = starts(Diffusion(), arrived(Diffusion(), ahead, speed), np.full(steps, ahead), np.full(steps, speed))
    assert (start < steps).mean() > 0.9
    assert start.mean() * DT > 0.3  # it takes time to see that, too


def test_a_car_that_brakes_is_let_pass_less_often():
    time = DT * np.arange(20)
    held = 25 - 8 * time, np.full(20, 8.0)
    braking = 25 - 8 * time + 1.5 * time**2, 8 - 3 * time
    memory = arrived(Diffusion(), 25.8, 8.0)
    go_on, yielded = (starts(Diffusion(), memory, *course)[0] < 20 for course in (held, braking))
    assert yielded.mean() > go_on.mean() + 0.3
    by_hand = eqx.filter_jit(acceleration)(memory, np.full((PEOPLE, 1), 7.7, np.float32), DT)
    np.testing.assert_allclose(by_hand, -3.0, atol=1e-3)


def test_distracted_people_start_later_and_into_shorter_gaps():
    ahead, speed = constant(5.0, 8.0)
    usual, late = (starts(kind, arrived(kind, 40.8), ahead, speed)[0] for kind in (Diffusion(), Distracted()))
    left = [5.0 - DT * start[start < len(ahead)] for start in (usual, late)]
    assert late.min() * DT >= 1.0 - DT
    assert left[1].mean() < left[0].mean() - 0.2
    assert (left[1] < 3.25).mean() > (left[0] < 3.25).mean() + 0.1  # 3.2 s, however it is rounded, counts


def test_distracted_people_judge_by_what_they_saw_on_arrival():
    far, near, fast = np.full(25, 60.0), np.full(25, 3.0), np.full(25, 8.0)
    trusting, _ = starts(Distracted(), arrived(Distracted(), 60.0), near, fast)
    wary, _ = starts(Distracted(), arrived(Distracted(), 3.0), far, fast)
    assert (trusting < 25).mean() > 0.4  # the car is 0.4 s away
    assert (wary <= 10).mean() < 0.02


def test_half_of_gaps_of_6_6_seconds_are_accepted():
    go, _ = decided(GapAccepting(), np.uint32(0), kerb(6.6 * 8, 8.0), arrived(GapAccepting()))
    assert np.asarray(go).mean() == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("name", POPULATIONS)
def test_whoever_has_nothing_to_decide_goes(name):
    policy = POPULATIONS[name]()
    blind = np.zeros((20, PEOPLE, 1), np.float32)
    seen = kerb(1.0, 8.0, deciding=False) if policy.view.name == "kerb" else blind
    go, _ = decided(policy, np.uint32(0), seen)
    assert np.asarray(go).all()


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
    gap = eqx.filter_jit(kerb_gap)(kerb(8 * seconds, 8, people=1))
    group, phone, waited = (np.full((1, 1), x, kind) for x, kind in ((group, "f4"), (phone, bool), (waited, "f4")))
    found = eqx.filter_jit(chance)(gap, group, phone, waited)
    assert found.item() == pytest.approx(expected, rel=1e-4)


def test_pedsumo_draws_once_a_second():
    steps, share = 25, 0.4 * 0.1
    _, went = starts(PedSumo(), arrived(PedSumo()), np.full(steps, 2.0 * 8), np.full(steps, 8.0), longest=steps)
    gone = went.mean(axis=1)
    drew = np.flatnonzero(np.diff(gone, prepend=0) > 0)
    assert drew.tolist() == [0, 10, 20]
    mean = share * 1.4 * (1 - PHONES + PHONES * 1.5)  # everybody stands at one place: a large group
    np.testing.assert_allclose(gone[[0, 10, 20]], 1 - (1 - mean) ** np.arange(1, 4), atol=0.015)


def test_pedsumo_counts_who_decides_nearby():
    seen = np.array(kerb(np.array([10.0, 12.0, 12.5, 30.0, 10.0])[:, None], 8.0, people=5))
    seen[part("pedestrian", "kerb", "decides").start, 4] = 0
    sizes = eqx.filter_jit(lambda seen: group_sizes(kerb_gap(seen)))(seen)
    assert np.asarray(sizes)[:, 0].tolist() == [3, 3, 3, 1, 3]
