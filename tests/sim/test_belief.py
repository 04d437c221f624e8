"""What could be inferred about people: Bayes' rule, what is counted, and what the driver's sets show of it."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import integrate

from jaxwalk.evaluation import with_jaywalk_multiplier
from jaxwalk.sim import belief
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK, NO_CROSSING
from jaxwalk.sim.observation import BELIEF, FOOTPRINT, TOLD, part
from jaxwalk.sim.scenario import Scenario
from sim.play import ENVIRONMENTS, PEOPLE, actions, columns, compiled, people, play, refreshed, reset

TYPES = (JAYWALK, CROSSWALK)
posterior, tendency = compiled(belief.posterior), compiled(Scenario.jaywalking_tendency)


def integrated(jaywalks, crosswalks, multiplier):
    """Mean and standard deviation of the posterior, by adaptive integration on both sides of its kink."""
    certain = min(1.0, 1 / multiplier)

    def moment(power):
        def density(tau):
            p = min(1.0, multiplier * tau)
            return tau**power * (p / multiplier) ** jaywalks * (1 - p) ** crosswalks

        return sum(integrate.quad(density, *ends, epsabs=0, epsrel=1e-10)[0] for ends in ((0, certain), (certain, 1)))

    mean = moment(1) / moment(0)
    return mean, np.sqrt(moment(2) / moment(0) - mean**2)


@pytest.mark.parametrize("multiplier", [0.01, 0.25, 0.6, 1.0, 1.7, 4.0])
def test_the_posterior_is_the_integral(multiplier):
    cases = [(0, 0), (1, 0), (0, 1), (1, 1), (3, 2), (0, 12), (12, 0), (6, 6), (1, 40), (20, 20)]
    jaywalks, crosswalks = np.array(cases, np.int32).T
    found = posterior(jaywalks, crosswalks, np.float32(multiplier))
    np.testing.assert_allclose(np.stack(found, 1), [integrated(*case, multiplier) for case in cases], atol=1e-5)


def test_nothing_seen_nothing_learned():
    mean, deviation = posterior(np.int32(0), np.arange(9, dtype=np.int32), np.float32(0))  # nobody ever jaywalks
    np.testing.assert_allclose(mean, 0.5, atol=1e-6)
    np.testing.assert_allclose(deviation, 12**-0.5, atol=1e-6)


@pytest.mark.parametrize("multiplier", [0.25, 1.0, 1.7])
def test_the_posterior_is_what_remains_of_many(multiplier):
    """Draw many people and their crossings, keep those who did what was seen: their tendencies are the posterior."""
    random = np.random.default_rng(0)
    tau = random.random(400_000)
    jaywalks = (random.random((4, len(tau))) < multiplier * tau).sum(axis=0)
    for seen in range(5):
        alike = tau[jaywalks == seen]
        if len(alike) < 100:
            continue
        mean, deviation = posterior(np.int32(seen), np.int32(4 - seen), np.float32(multiplier))
        error = 5 * deviation / len(alike) ** 0.5
        assert abs(mean - alike.mean()) < error
        assert abs(deviation - alike.std()) < error


def seen_so_far(street, scenario, state):
    world, walkers = street.world, state.pedestrian
    counts = belief.crossings_seen(world, scenario, walkers)
    return counts, belief.expected_tendency(world, scenario, walkers)


_seen = compiled(seen_so_far)


@compiled
def _look(street, scenario, state):
    return [street.observe(scenario, state, street.view("driver", name)) for name in (FOOTPRINT, TOLD, BELIEF)]


@pytest.fixture(scope="module")
def jaywalking(paid_street):
    """The street on which half of the crossings are jaywalks."""
    return with_jaywalk_multiplier(paid_street, 1.0)


@jax.jit
def _walk(street, scenario, state):
    """The state 100 steps later, everybody walking, and what was counted after each step."""

    def body(state, _):
        state, _ = street.step(scenario, state, actions())
        return state, jnp.stack(seen_so_far(street, scenario, state)[0])

    return jax.lax.scan(body, state, None, length=100)


@pytest.fixture(scope="module")
def walked(jaywalking, scenarios):
    """Everybody walks for 500 steps: states and counts of each hundred."""
    parts = [(reset(jaywalking, scenarios), None)]
    for _ in range(5):
        parts.append(_walk(jaywalking, scenarios, parts[-1][0]))
    return parts[1:]


@pytest.fixture(scope="module")
def stepped(street, walked, scenarios):
    """Counts after every one of 500 steps (step, type, ped, env), and the frames."""
    unpaid = with_jaywalk_multiplier(street, 1.0)  # or `play` is compiled anew
    return np.concatenate([counts for _, counts in walked]), play(unpaid, scenarios)


def test_a_crossing_counts_from_the_roadway_on(stepped):
    """Against the frames: rising edges of being on the roadway, by the decision."""
    counts, frames = stepped
    enters = frames["on_roadway"][1:] & ~frames["on_roadway"][:-1]
    for kind, found in zip(TYPES, counts.swapaxes(0, 1), strict=True):
        np.testing.assert_array_equal(found, np.cumsum(enters & (frames["crossing"][1:] == kind), axis=0))


def test_what_is_only_decided_does_not_count(stepped):
    counts, frames = stepped
    decided = frames["decisions"][1:]
    total = counts.sum(axis=1)
    on_the_way = (decided > total) & (frames["crossing"][1:] == JAYWALK)
    assert on_the_way.sum() > 1000
    assert not (on_the_way & frames["on_roadway"][1:]).any()
    np.testing.assert_array_equal(decided - total, np.where(frames["crossing"][1:] == NO_CROSSING, 0, decided > total))
    assert counts.max(axis=(0, 2, 3)).min() >= 3


def nearest(state, of_all):
    """Of the nearest six, by a stable sort."""
    (x, y), car = (np.asarray(of) for of in (state.pedestrian.x, state.pedestrian.y)), state.vehicle
    away = np.hypot(x - np.asarray(car.x), y - np.asarray(car.y))
    return np.take_along_axis(np.asarray(of_all), np.argsort(away, axis=0, kind="stable")[:6], axis=0)


@pytest.fixture(scope="module")
def looked(jaywalking, scenarios, walked):
    """After 300 steps of walking, the state and what the driver's sets show of it."""
    state = refreshed(jaywalking, scenarios, walked[2][0])  # as the tests do: other programs round differently
    return state, _look(jaywalking, scenarios, state)


def test_the_sets_end_with_the_nearest_peoples_numbers(jaywalking, scenarios, looked):
    state, (route, told, believed) = looked
    for seen in (told, believed):
        np.testing.assert_array_equal(seen[: len(route)], route)
    np.testing.assert_array_equal(
        told[part("driver", TOLD, "tendencies")], nearest(state, tendency(scenarios, jaywalking.world))
    )
    (jaywalks, crosswalks), _ = _seen(jaywalking, scenarios, state)
    means, _ = posterior(jaywalks, crosswalks, np.float32(1))
    shown = believed[part("driver", BELIEF, "tendencies")]
    np.testing.assert_allclose(shown, nearest(state, means), atol=1e-6)
    assert len(np.unique(shown.round(4))) > 5


def test_who_is_who_does_not_show(jaywalking, scenarios, looked):
    state, seen = looked
    scenario, state = people(scenarios, state, np.random.default_rng(0).permutation(PEOPLE))
    again = _look(jaywalking, scenario, refreshed(jaywalking, scenario, state))
    for before, after in zip(seen, again, strict=True):
        np.testing.assert_allclose(after, before, atol=1e-6)


def test_of_who_is_not_there_nothing_is_known(jaywalking, scenarios, looked):
    scenario, state = people(scenarios, looked[0], [3, 5])
    _, told, believed = _look(jaywalking, scenario, refreshed(jaywalking, scenario, state))
    np.testing.assert_array_equal(told[-4:], 0.5)
    np.testing.assert_array_equal(believed[-4:], 0.5)
    np.testing.assert_array_equal(np.sort(told[-6:-4], 0), np.sort(tendency(scenario, jaywalking.world), 0))


def test_the_belief_knows_no_secret(jaywalking, scenarios, looked):
    """Crossings to come, and one that is decided but not begun, may be anything; so may the tendency itself, but for
    what was done."""
    state, (_, _, believed) = looked
    (jaywalks, crosswalks), _ = _seen(jaywalking, scenarios, state)
    drawn, traits = np.asarray(scenarios.jaywalk_draw), np.array(scenarios.traits)
    past = np.arange(len(drawn))[:, None, None] < jaywalks + crosswalks
    did = drawn < tendency(scenarios, jaywalking.world)
    draws = np.where(past, np.where(did, 0.0, 0.99), 1 - drawn).astype(np.float32)  # the same past for every tendency
    traits[0] = np.clip(1 - traits[0], 0.01, 0.98)
    other = eqx.tree_at(
        lambda s: (s.traits, s.jaywalk_draw, s.zone_draw),
        scenarios,
        (traits, draws, 1 - np.asarray(scenarios.zone_draw)),
    )
    np.testing.assert_array_equal(_look(jaywalking, other, state)[2], believed)


def test_one_episode_is_like_many(jaywalking, scenarios, looked):
    """Without a batch axis."""
    state, seen = looked
    alone = _look(jaywalking, columns(scenarios, 3), columns(state, 3))
    for one, all_of_them in zip(alone, seen, strict=True):
        assert all_of_them.shape[1] == ENVIRONMENTS
        np.testing.assert_allclose(one, all_of_them[:, 3], atol=1e-5)
