"""Kinds of people: their shares, how often they jaywalk and how fast they are; and files from before there were any."""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import equinox as eqx
import jax
import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError
from scipy import stats

from jaxwalk import SimConfig, Street
from jaxwalk.scenarios import Drawn
from jaxwalk.sim import belief, pedestrian
from jaxwalk.sim.crossing_kind import LegKind
from jaxwalk.sim.observation import Observation, bounds
from jaxwalk.sim.person_kind import CALM, CAMPUS, CHILD, HURRIED, KINDS, RUNNER, PersonKind, begins, in_shares
from jaxwalk.sim.scenario import Scenario
from jaxwalk.sim.sim_config import WORLDS
from pytrees import as_numpy
from sim.passersby import drawn, walked
from sim.play import compiled

SHARES = {"calm": 0.4, "hurried": 0.25, "runner": 0.2, "child": 0.15}
RULES = SimConfig(horizon=300, kinds=in_shares(**SHARES), jaywalk_multiplier=1.0)
BATCH = 256
TAUS = np.float32([0.02, 0.9, 0.3, 0.5])
WALK = np.array([(1, 2), (1, 2), (2.22, 3.5), (0.83, 1.39)])
ACROSS = np.array([(1, 2), (2.2, 3), (2.22, 3.5), (2.22, 3)])
kind_of, mean_of_kinds, prior_mean = map(compiled, (Scenario.kind, belief.mean_of_kinds, belief.prior_mean))


@pytest.fixture(scope="module")
def many():
    return Street.create(config=RULES)


@pytest.fixture(scope="module")
def scenarios(many):
    return drawn(many, BATCH)


def test_each_kind_has_its_share_of_the_first_trait():
    assert begins(RULES.kinds) == pytest.approx((0, 0.4, 0.65, 0.85))
    assert begins(()) == (0,)
    assert RULES.tendencies == {0.02: 0.4, 0.9: 0.25, 0.3: 0.2, 0.5: 0.15}
    twice = (CALM, replace(CALM, name="lame", walk=(0.4, 0.8)))
    assert SimConfig(kinds=tuple(replace(kind, share=0.5) for kind in twice)).tendencies == {0.02: 1.0}


def test_as_many_people_are_of_a_kind_as_its_share_says(many, scenarios):
    """3,072 people; each count lies within the exact binomial limits of one draw in 10,000 on either side."""
    kind = kind_of(scenarios, many.world)
    for number, share in enumerate(SHARES.values()):
        low, high = stats.binom.interval(0.9998, kind.size, share)
        assert low <= (kind == number).sum() <= high
    np.testing.assert_array_equal(compiled(Scenario.jaywalking_tendency)(scenarios, many.world), TAUS[kind])
    np.testing.assert_array_equal(compiled(Scenario.own_traits)(scenarios, many.world)[0], TAUS[kind])


def test_who_stands_at_the_border_is_of_the_later_kind(many, scenarios):
    """Of traits 0.4 and 0.65, and of the numbers just below them."""
    borders = np.float32([0.4, 0.65])
    traits = np.array(scenarios.traits)
    traits[0] = np.resize([*np.nextafter(borders, np.float32(0)), *borders], scenarios.start.shape)
    at = eqx.tree_at(lambda s: s.traits, scenarios, traits)
    assert kind_of(at, many.world).ravel()[:4].tolist() == [0, 1, 1, 2]


@compiled
def paces(world, scenarios):
    """How fast people are, and how fast they walk at the start."""
    people = pedestrian.place(world, scenarios)
    return scenarios.walking_speed(world), pedestrian.pace(world, scenarios, people)


def test_each_kind_walks_and_jaywalks_at_its_own_pace(many, scenarios):
    frames = as_numpy(walked(many, scenarios))
    kind, trait = kind_of(scenarios, many.world), np.asarray(scenarios.traits)[1]
    across = frames.leg == LegKind.ACROSS
    slowest, fastest = np.moveaxis(np.where(across[..., None], ACROSS[kind], WALK[kind]), -1, 0)
    np.testing.assert_allclose(frames.speed, slowest + (fastest - slowest) * trait, rtol=1e-5)
    assert all((across & (kind == number)).any() for number in range(4))
    assert frames.decisions.max() < scenarios.jaywalk_draw.shape[0]
    assert frames.arrivals.max() + 1 < scenarios.goals.shape[0]
    np.testing.assert_array_equal(*paces(many.world, scenarios))


def test_tables_and_bounds_are_those_of_the_fastest_kind(many):
    assert RULES.walking == (0.83, 3.5) and RULES.fastest == 3.5
    assert WORLDS["blind-corner"].walking == (1, 2) and WORLDS["blind-corner"].fastest == 3
    assert SimConfig().walking == (1, 2) and SimConfig(kinds=(replace(CHILD, share=1.0),)).fastest == 3
    low, high = bounds(many.world, "pedestrian", "kerb")
    pace = first_seen(many)
    assert (pace >= low[:, None]).all() and (pace <= high[:, None]).all()


@compiled
def first_seen(street):
    scenario = street.draw(jax.random.key(0))
    return street.observe(scenario, street.reset(scenario), Observation("pedestrian", "kerb"))


def by_hand(jaywalks, crosswalks, multiplier):
    """Bayes' rule for the four kinds."""
    kinds = zip(SHARES.values(), (0.02, 0.9, 0.3, 0.5), strict=True)
    weights = [(s * (multiplier * t) ** jaywalks * (1 - multiplier * t) ** crosswalks, t) for s, t in kinds]
    return sum(w * t for w, t in weights) / sum(w for w, _ in weights)


@pytest.mark.parametrize("multiplier", [0.25, 1.0])
def test_beliefs_are_those_of_four_kinds(multiplier):
    world = Street.create(config=RULES, jaywalk_multiplier=multiplier).world
    cases = [(0, 0), (1, 0), (0, 1), (2, 3), (0, 12), (6, 1)]
    found = mean_of_kinds(world, *np.array(cases, np.int32).T)
    np.testing.assert_allclose(found, [by_hand(*case, multiplier) for case in cases], rtol=2e-5)
    assert float(prior_mean(world)) == pytest.approx(0.4 * 0.02 + 0.25 * 0.9 + 0.2 * 0.3 + 0.15 * 0.5)


def test_kinds_that_walk_no_faster_change_no_scenario(street):
    """A kind is read from a trait that everybody has anyway."""
    slow = Street.create(
        config=SimConfig(kinds=(replace(CALM, share=0.5), replace(RUNNER, share=0.5, walk=(1.5, 2.0))))
    )
    assert Drawn(slow, 77, 16).hash() == Drawn(street, 77, 16).hash()
    assert not kind_of(drawn(street, BATCH), street.world).any()


def test_scenarios_of_people_in_a_hurry_are_those_from_before_there_were_kinds():
    street = Street.create(
        ["validation-1000000003", "validation-1000000004"], replace(WORLDS["blind-corner"], horizon=300)
    )
    assert Drawn(street, 77, 64).hash() == "c5bbd2cb65d390d2"


@pytest.mark.parametrize("rules", [*WORLDS.values(), RULES])
def test_a_file_of_the_rules_is_read_back(rules):
    reader = TypeAdapter(SimConfig)
    assert reader.validate_json(json.dumps(asdict(rules)), strict=True) == rules
    assert reader.validate_json(reader.dump_json(rules)) == rules
    assert Street.create(config=rules).config == rules


@pytest.mark.parametrize(
    ("hurried", "kinds"), [(0.0, ()), (0.25, in_shares(calm=0.75, hurried=0.25)), (1.0, in_shares(hurried=1.0))]
)
def test_a_file_from_before_there_were_kinds_is_read(hurried, kinds):
    old = {"hurried": hurried, "hurried_tendency": 0.9, "other_tendency": 0.02, "slowest_hurry": 2.2}
    found = TypeAdapter(SimConfig).validate_json(json.dumps({"dt": 0.2, **old, "fastest_hurry": 3.0}), strict=True)
    assert found == SimConfig(dt=0.2, kinds=kinds)


def test_rules_that_are_no_object_are_refused_as_such():
    """The error is that of the rules, and says nothing of kinds."""
    with pytest.raises(ValidationError, match="Input should be an object"):
        TypeAdapter(SimConfig).validate_json("[1, 2]", strict=True)


def test_named_kinds_have_their_names():
    assert KINDS == {"calm": CALM, "hurried": HURRIED, "runner": RUNNER, "child": CHILD, "campus": CAMPUS}
    with pytest.raises(ValueError, match="no kind 'adult' of people; there are: calm, hurried, runner, child"):
        in_shares(adult=1.0)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"share": 0.0}, "the share of 'x' must be above 0 and at most 1, not 0.0"),
        ({"share": float("nan")}, "the share of 'x' must be above 0"),
        ({"tendency": 1.5}, "the tendency of 'x' must lie in \\[0, 1\\], not 1.5"),
        ({"walk": (0.0, 1.0)}, "both speeds of walk of 'x' must be above 0"),
        ({"jaywalk": (3.0, 2.2)}, "both speeds of jaywalk of 'x' must be .* the second one no lower"),
        ({"walk": (1.0, 21.0)}, "both speeds of walk of 'x' must be above 0, at most 20 m/s"),
    ],
)
def test_an_impossible_kind_is_refused(wrong, message):
    with pytest.raises(ValueError, match=f"kinds: {message}"):
        PersonKind(**{"name": "x", "share": 0.5, "tendency": 0.5, **wrong})


def test_impossible_shares_are_refused():
    with pytest.raises(ValueError, match=r"kinds: the shares are 0\.9 together, not 1; change one, or add a kind"):
        SimConfig(kinds=in_shares(calm=0.5, hurried=0.4))
    with pytest.raises(ValueError, match="kinds: there are two kinds 'calm'; name each once"):
        SimConfig(kinds=(replace(CALM, share=0.5), replace(CALM, share=0.5)))
