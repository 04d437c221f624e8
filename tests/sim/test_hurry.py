"""People in a hurry: who they are, how often and how fast they jaywalk, and that nobody steps out through a vehicle."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import numpy as np
import pytest
import shapely

from jaxwalk import SimConfig, Street
from jaxwalk.evaluation import with_jaywalk_multiplier
from jaxwalk.evaluation.settings import jaywalk_multiplier
from jaxwalk.maps.parking_slots import box_corners
from jaxwalk.sim import belief
from jaxwalk.sim.crossing_kind import JAYWALK, LegKind
from jaxwalk.sim.jaywalk import into_gap
from jaxwalk.sim.observation import BELIEF, TOLD, Observation, part
from jaxwalk.sim.parked_gaps import NO_SLOT
from jaxwalk.sim.person_kind import HURRIED, in_shares
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.sim_config import WORLDS, rules_of
from jaxwalk.sim.walking_paths import walking_paths
from sim.passersby import drawn, walked
from sim.play import compiled

STREETS, BATCH = ["validation-1000000003", "validation-1000000004"], 32
RULES = replace(WORLDS["blind-corner"], kinds=in_shares(calm=0.7, hurried=0.3), horizon=300)
kind, tendency = compiled(Scenario.kind), compiled(Scenario.jaywalking_tendency)
mean_of_kinds, prior_mean = compiled(belief.mean_of_kinds), compiled(belief.prior_mean)


@pytest.fixture(scope="module")
def hurrying():
    return Street.create(STREETS, RULES)


@pytest.fixture(scope="module")
def scenarios(hurrying):
    return drawn(hurrying, BATCH)


@pytest.fixture(scope="module")
def frames(hurrying, scenarios):
    return jax.tree.map(np.asarray, walked(hurrying, scenarios))


def test_a_share_of_the_people_has_one_tendency_and_the_others_have_another(hurrying, scenarios):
    tau, traits = tendency(scenarios, hurrying.world), np.asarray(scenarios.traits)
    np.testing.assert_array_equal(tau, np.where(traits[0] >= np.float32(0.7), np.float32(0.9), np.float32(0.02)))
    assert abs((tau > 0.5).mean() - 0.3) < 4 * (0.3 * 0.7 / tau.size) ** 0.5


def test_they_jaywalk_as_often_as_their_tendency_says(hurrying, scenarios, frames):
    hurries = kind(scenarios, hurrying.world) == 1
    decided = np.diff(frames.decisions, axis=0) == 1
    jaywalks = frames.crossing[1:] == JAYWALK
    for who, least, most in ((hurries, 0.6, 0.95), (~hurries, 0.0, 0.06)):  # some crossings have no zone beside them
        share = jaywalks[decided & who].mean()
        assert least < share < most


def test_who_hurries_is_fast_on_a_jaywalk_and_nowhere_else(hurrying, scenarios, frames):
    across = frames.leg == LegKind.ACROSS
    hurries, traits = kind(scenarios, hurrying.world) == 1, np.asarray(scenarios.traits)
    fast = across & hurries
    expected = np.where(fast, 2.2 + 0.8 * traits[1], 1 + traits[1])
    assert fast.sum() > 1000 and (across & ~hurries).any()
    np.testing.assert_allclose(frames.speed, expected, rtol=1e-5)
    moved = np.hypot(np.diff(frames.x, axis=0), np.diff(frames.y, axis=0))
    straight = across[1:] & across[:-1]
    np.testing.assert_allclose(moved[straight], 0.1 * expected[1:][straight], atol=1e-3)


def test_tables_last_where_everybody_hurries_all_the_time():
    street = Street.create(
        STREETS, replace(RULES, kinds=(replace(HURRIED, tendency=1.0),), parked=0.0, perception=False)
    )
    scenarios = drawn(street, BATCH)
    scenarios = eqx.tree_at(lambda s: s.traits, scenarios, np.ones(scenarios.traits.shape, np.float32))
    frames = jax.tree.map(np.asarray, walked(street, scenarios))
    assert (frames.crossing == JAYWALK).any()
    assert frames.decisions.max() < scenarios.jaywalk_draw.shape[0]
    assert frames.arrivals.max() + 1 < scenarios.goals.shape[0]


def ways(street, scenarios):
    """The near halves of all jaywalks with whether they meet a parked vehicle: (x, y) of the begin and that, each."""
    world, paths = street.world, walking_paths(street.world, scenarios, reach=100.0)
    corners, maps, parked = box_corners(np.asarray(world.maps.slots)), np.asarray(scenarios.map), scenarios.parked
    boxes = [shapely.union_all(shapely.polygons(corners[maps[e]][np.asarray(parked)[:, e]])) for e in range(BATCH)]
    found = []
    for leg, ped, e in zip(*np.nonzero(paths.jaywalk), strict=True):
        begin, end = np.array([[paths.x[k, ped, e], paths.y[k, ped, e]] for k in (leg, leg + 1)])
        found.append((*begin, shapely.LineString([begin, (begin + end) / 2]).intersects(boxes[e])))
    return np.array(found)


def test_nobody_steps_out_through_a_parked_vehicle(hurrying, scenarios):
    assert (np.asarray(hurrying.world.parked_gaps)[..., 0] != NO_SLOT).sum() >= 10
    *_, through = ways(hurrying, scenarios).T
    assert len(through) > 100 and not through.any()
    through_walls = replace(hurrying, world=replace(hurrying.world, parked_gaps=None))
    *_, through = ways(through_walls, scenarios).T
    assert through.sum() > 20


def test_where_nobody_parks_jaywalks_are_as_ever(hurrying, scenarios):
    empty = replace(scenarios, parked=jax.device_put(np.zeros(scenarios.parked.shape, bool)))
    as_ever = replace(hurrying, world=replace(hurrying.world, parked_gaps=None))
    np.testing.assert_allclose(ways(hurrying, empty), ways(as_ever, empty), atol=1e-4)


def test_a_jaywalk_beside_a_vehicle_begins_in_the_nearest_gap(hurrying, scenarios):
    """A vehicle in slot 0 is in the way from place 2 to 4; its gaps are at 1.5 and at 4.6. Slot 1 is empty."""
    entries = np.array([[0, 2, 4, 1.5, 4.6], [1, 6, 8, 5.5, 8.5], [NO_SLOT] * 5], np.float32)
    table = np.broadcast_to(entries, hurrying.world.parked_gaps.shape)
    world = replace(hurrying.world, parked_gaps=jax.device_put(table))
    parked = np.zeros(scenarios.parked.shape, bool)
    parked[0] = True
    begins, instead = [1.9, 2.1, 3.0, 3.1, 3.9, 4.1, 7.0, 9.0], [1.9, 1.5, 1.5, 4.6, 4.6, 4.1, 7.0, 9.0]
    shape = scenarios.start.shape
    at = replace(scenarios, parked=jax.device_put(parked))
    found = compiled(into_gap)(world, at, np.zeros(shape, np.int32), np.resize(np.float32(begins), shape))
    np.testing.assert_allclose(found, np.resize(instead, shape), rtol=1e-6)


def by_hand(jaywalks, crosswalks, multiplier):
    """Bayes' rule for three in ten with 0.9 and seven in ten with 0.02."""
    weights = [
        share * min(1, multiplier * tau) ** jaywalks * (1 - min(1, multiplier * tau)) ** crosswalks
        for share, tau in ((0.3, 0.9), (0.7, 0.02))
    ]
    return (weights[0] * 0.9 + weights[1] * 0.02) / sum(weights)


@pytest.mark.parametrize("multiplier", [0.25, 1.0, 1.1])
def test_the_belief_starts_from_the_worlds_prior(hurrying, multiplier):
    world = with_jaywalk_multiplier(hurrying, multiplier).world
    cases = [(0, 0), (1, 0), (0, 1), (2, 1), (0, 20), (7, 9)]
    found = mean_of_kinds(world, *np.array(cases, np.int32).T)
    np.testing.assert_allclose(found, [by_hand(*case, multiplier) for case in cases], rtol=2e-5)
    assert float(prior_mean(world)) == pytest.approx(0.3 * 0.9 + 0.7 * 0.02)


def test_what_nobody_would_do_teaches_nothing(hurrying):
    world = with_jaywalk_multiplier(hurrying, 0.0).world  # nobody ever jaywalks
    one, none, five = np.array([1, 0, 5], np.int32)
    assert float(mean_of_kinds(world, one, none)) == pytest.approx(0.284)
    assert float(mean_of_kinds(world, none, five)) == pytest.approx(0.284)


SHOWN = [("pedestrian", "paper"), ("pedestrian", "kerb"), ("driver", TOLD), ("driver", BELIEF)]


@compiled
def first_shown(street, scenarios):
    """What each of these sets shows at the start, and what the global state does."""
    state = street.reset(scenarios)
    sets = {(role, name): street.observe(scenarios, state, Observation(role, name)) for role, name in SHOWN}
    return sets, street.global_state(scenarios, state)


def test_every_view_of_a_tendency_shows_the_worlds(hurrying, scenarios):
    seen, everything = first_shown(hurrying, scenarios)
    tau = tendency(scenarios, hurrying.world)

    def look(role, name, feature):
        return seen[role, name][part(role, name, feature)]

    np.testing.assert_array_equal(look("pedestrian", "paper", "traits")[0], tau)
    np.testing.assert_array_equal(look("pedestrian", "kerb", "traits")[0], tau)
    prior = np.float32(0.284)
    np.testing.assert_allclose(np.unique(look("driver", TOLD, "tendencies")), [0.02, prior, 0.9], rtol=1e-5)
    np.testing.assert_allclose(look("driver", BELIEF, "tendencies"), prior, rtol=1e-5)  # nobody has crossed yet
    np.testing.assert_array_equal(everything[36:48], tau)


def test_a_world_names_its_multiplier_and_whoever_gives_one_wins(hurrying):
    assert {name: rules.jaywalk_multiplier for name, rules in WORLDS.items()} == {
        "paper": 0.25, "paper-footprint": 0.25, "campus": 0.25, "town": 0.25, "blind-corner": 1.0, "arterial": 1.0,
        "test-track": 0.25,
    }  # fmt: skip
    assert rules_of("blind-corner", ()).jaywalk_multiplier == 1
    assert rules_of("paper", (), WORLDS["blind-corner"]) == SimConfig()
    assert jaywalk_multiplier(hurrying) == hurrying.config.jaywalk_multiplier == 1
    often = Street.create(config=SimConfig(jaywalk_multiplier=0.5), jaywalk_multiplier=0.7)
    assert often.config == SimConfig(jaywalk_multiplier=0.7)
    assert with_jaywalk_multiplier(often, 0.1).config == SimConfig(jaywalk_multiplier=0.1)
