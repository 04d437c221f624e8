"""What the car perceives: nobody hidden reaches a driver, last seen people are kept, and chance is the scenario's."""

from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from jax import device_put

from jaxwalk import Street
from jaxwalk.evaluation import play
from jaxwalk.interfaces import Moment
from jaxwalk.policies import AlwaysGo, RouteFollower
from jaxwalk.sim import prediction
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK
from jaxwalk.sim.observation import AWARE, OBSERVATIONS, PRIVILEGED_SETS, Observation, part
from jaxwalk.sim.occluders import PADDING
from jaxwalk.sim.perceived import KEPT, Sighting
from jaxwalk.sim.perception import _arrive, chance
from jaxwalk.sim.prediction import foresee
from jaxwalk.sim.trajectory import part_of
from sim import passersby
from sim.hiding import BATCH, RULES, STEPS, drawn, drive, hiding_street, look, play_on, x_ray
from sim.play import compiled

VIEWS = [name for name in OBSERVATIONS["driver"] if name not in PRIVILEGED_SETS]


@pytest.fixture(scope="module")
def hiding():
    return hiding_street()


@pytest.fixture(scope="module")
def scenarios(hiding):
    return drawn(hiding)


@pytest.fixture(scope="module")
def played(hiding, scenarios):
    return drive(hiding, scenarios)


@eqx.filter_jit
def views(street, scenarios, state):
    """All that drivers see, but for sets that nobody could have."""
    return {name: Observation("driver", name)(Moment(street.world, scenarios, state)) for name in VIEWS}


def test_some_are_hidden_and_nothing_of_them_is_perceived(played):
    _, (perceived, *_) = played
    assert 0.1 < np.asarray(perceived.in_sight).mean() < 0.9
    now = perceived.now
    for column in jax.tree.leaves(now):  # nothing of those whom nobody sees is handed on
        assert not np.asarray(column)[~np.asarray(now.seen)].any()


def test_no_driver_notices_what_hidden_people_do(hiding, scenarios, played):
    """Hidden people are moved about, their traits, legs and pace too; every view of every driver stays as it was."""
    state, _ = played
    hidden = ~np.asarray(state.perceived.now.seen)
    assert hidden.sum() > BATCH
    random = np.random.default_rng(77)

    def shaken(values):
        values = np.asarray(values)
        other = random.permuted(values, axis=-1) + (random.random(values.shape) < 0.5).astype(values.dtype)
        return device_put(np.where(hidden, other.astype(values.dtype), values))

    moved = jax.tree.map(shaken, state.pedestrian)
    strangers = replace(scenarios, traits=device_put(np.stack([shaken(x) for x in np.asarray(scenarios.traits)])))
    seen = eqx.filter_jit(foresee)(hiding.world, strangers, state.vehicle, moved, state.perceived)
    other = replace(state, pedestrian=moved, foresight=seen)
    before, after = views(hiding, scenarios, state), views(hiding, strangers, other)
    assert not np.array_equal(state.pedestrian.x, moved.x, equal_nan=True)
    for name in VIEWS:
        np.testing.assert_array_equal(before[name], after[name], err_msg=name)


def test_told_tendencies_are_of_perceived_people_only(hiding, scenarios, played):
    state, _ = played
    told = "route-footprint-told"
    traits = np.array(scenarios.traits)
    traits[0] = np.where(state.perceived.now.seen, traits[0], 1 - traits[0])
    others = replace(scenarios, traits=device_put(traits))
    one, other = (look(hiding, x, state, told) for x in (scenarios, others))
    np.testing.assert_array_equal(one, other)


@pytest.mark.long
def test_where_everybody_is_in_sight_drivers_see_what_they_saw(hiding, scenarios):
    """Without occluders and with a long range, all views are those of a world without perception."""
    far = replace(hiding.world.rules, sight=jnp.float32(1000))
    nothing = jax.tree.map(lambda table: jnp.full_like(table, PADDING), hiding.world.occluders)
    clear = replace(hiding, world=replace(hiding.world, rules=far, occluders=nothing))
    usual = replace(hiding, world=replace(hiding.world, rules=replace(far, perception=False)))
    (one, _), (other, _) = drive(clear, scenarios), play_on(usual, scenarios)
    assert np.asarray(one.perceived.in_sight).all()
    assert other.perceived is None
    for name in VIEWS:
        if "belief" in name or name == AWARE:
            continue  # beliefs count crossings that were seen, the other ones those that were made; places stay hidden
        before, after = (look(hiding, scenarios, x, name) for x in (other, one))
        np.testing.assert_allclose(after, before, atol=2e-3, err_msg=name)
    np.testing.assert_allclose(x_ray(hiding, scenarios, one), x_ray(usual, scenarios, other), atol=2e-3)
    for name in OBSERVATIONS["pedestrian"]:
        before, after = (look(hiding, scenarios, x, name, "pedestrian") for x in (other, one))
        np.testing.assert_allclose(after, before, atol=2e-3, err_msg=name)


def test_all_crossings_count_if_everybody_is_in_sight(hiding, scenarios):
    """Against the frames: each decision that led onto the roadway counts once, also over an island."""
    rules = replace(hiding.world.rules, sight=jnp.float32(1000))
    nothing = jax.tree.map(lambda table: jnp.full_like(table, PADDING), hiding.world.occluders)
    everywhere = replace(hiding.world, rules=rules, occluders=nothing)
    state, (_, _, _, *frames) = drive(replace(hiding, world=everywhere), scenarios)
    on_roadway, crossing, decisions = map(np.asarray, frames)
    counted = state.perceived.crossings
    for kind, found in ((JAYWALK, counted.jaywalks), (CROSSWALK, counted.crosswalks)):
        crosses = on_roadway & (crossing == kind)
        new = [(crosses & (decisions == number)).any(axis=0) for number in range(1, decisions.max() + 1)]
        np.testing.assert_array_equal(found, np.sum(new, axis=0))
        assert np.sum(new) > 5


def test_last_seen_is_the_last_place_in_sight_and_is_kept_for_three_seconds(hiding, played):
    _, (perceived, x, *_) = played
    seen, age = np.asarray(perceived.in_sight), np.asarray(perceived.age)
    x, last_x, kept = np.asarray(x), np.asarray(perceived.last.x), np.asarray(perceived.last.seen)
    episodes = [(p, b) for p in range(12) for b in range(BATCH) if seen[:, p, b].any() and not seen[:, p, b].all()]
    lost = 0
    for p, b in episodes:
        for step in range(int(np.flatnonzero(seen[:, p, b])[0]), STEPS):
            before = np.flatnonzero(seen[: step + 1, p, b])[-1]
            assert last_x[step, p, b] == x[before, p, b]
            np.testing.assert_allclose(age[step, p, b], 0.1 * (step - before), atol=1e-4)
            if abs(step - before - KEPT / 0.1) > 1:  # but for rounding of 3 s
                assert kept[step, p, b] == (step - before <= KEPT / 0.1)
                lost += not kept[step, p, b]
    assert lost > 0


def test_people_who_dont_see_the_car_have_nothing_to_decide(hiding, scenarios, played):
    state, _ = played
    kerb = np.asarray(look(hiding, scenarios, state, "kerb", "pedestrian"))
    unseen = ~np.asarray(state.perceived.in_sight)
    for name, value in {"decides": 0, "car_motion": 0, "direction": 0, "miss": 1}.items():
        assert (kerb[part("pedestrian", "kerb", name)][:, unseen] == value).all(), name


def test_rewards_and_recordings_are_of_people_as_they_are(hiding, scenarios, played):
    state, _ = played

    @compiled
    def found(world, scenario, state):
        ways = prediction.people_ahead, prediction.clearance_at_held_speed, prediction.motion_of_people
        return foresee(world, scenario, state.vehicle, state.pedestrian), [way(world, scenario, state) for way in ways]

    truth, ((crosswalk_user, jaywalker), held, motion) = found(hiding.world, scenarios, state)
    np.testing.assert_array_equal(crosswalk_user, truth.crosswalk_user)
    np.testing.assert_array_equal(jaywalker, truth.jaywalker)
    np.testing.assert_allclose(held, truth.clearance[1], atol=1e-5)
    np.testing.assert_allclose(motion.ahead, truth.people.ahead, atol=1e-5)


def test_chance_is_the_scenarios_and_looks_random(scenarios):
    steps = [jnp.full(BATCH, step) for step in range(40)]
    draw = eqx.filter_jit(chance)
    numbers = np.stack([draw(scenarios, step, 0) for step in steps])
    np.testing.assert_array_equal(numbers[3], draw(scenarios, steps[3], 0))  # a step stays deterministic
    flat = np.sort(numbers.ravel())
    assert abs(flat - np.arange(flat.size) / flat.size).max() < 2 / np.sqrt(flat.size)  # Kolmogorov-Smirnov
    for one, other in ((numbers[1:], numbers[:-1]), (numbers[:, 1:], numbers[:, :-1])):
        assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1]) < 4 / np.sqrt(one.size)
    assert abs(np.corrcoef(numbers[0].ravel(), np.ravel(draw(scenarios, steps[0], 1)))[0, 1]) < 0.2


def test_misses_noise_and_delay_are_as_large_as_they_say(hiding, scenarios):
    """Delayed by three steps, missed in a fifth of all steps, and off by a decimetre."""
    dials = replace(hiding.world.rules, delay=0.3, misses=0.2, position_noise=0.1)
    street = replace(hiding, world=replace(hiding.world, rules=dials))
    _, (perceived, x, y, *_) = drive(street, scenarios)
    now, visible = perceived.now, np.asarray(perceived.in_sight)[:-3]
    seen = np.asarray(now.seen)[3:]
    assert not (seen & ~visible).any()
    share = 1 - seen[visible].mean()
    assert abs(share - 0.2) < 4 * np.sqrt(0.16 / visible.sum())
    off = np.concatenate([(np.asarray(a)[3:] - np.asarray(b)[:-3])[seen] for a, b in ((now.x, x), (now.y, y))])
    assert abs(off.mean()) < 4 * 0.1 / np.sqrt(off.size)
    assert abs(off.std() - 0.1) < 4 * 0.1 / np.sqrt(2 * off.size)
    np.testing.assert_allclose(np.asarray(perceived.age)[3:][seen], 0.3, atol=1e-6)


def test_a_crossing_counts_once_however_often_it_is_seen(hiding, played):
    """By hand: seen on a jaywalk, hidden, seen on it again, then on a crosswalk; one of each counts."""
    state, _ = played
    before = jax.tree.map(lambda x: device_put(np.zeros((1,) * x.ndim, x.dtype)), state.perceived)
    arrive, nought = eqx.filter_jit(_arrive), np.float32(0)
    for seen, crossing, decisions in ((True, 2, 1), (False, 2, 1), (True, 2, 1), (True, 0, 1), (True, 1, 2)):
        values = (np.bool_(seen), *[nought] * 4, np.bool_(crossing > 0), np.int32(crossing), np.int32(decisions))
        one = [device_put(np.full((1, 1), value)) for value in values]
        before = arrive(hiding.world, before, one[0], Sighting(*one))
    assert (before.crossings.jaywalks.item(), before.crossings.crosswalks.item()) == (1, 1)


def test_a_view_without_perception_costs_nothing(scenarios):
    """The state of the paper's world has no leaf more than it had."""
    paper = Street.create()
    assert paper.world.occluders is None
    state = jax.eval_shape(lambda key: paper.reset(paper.draw(key)), jax.random.key(0))
    assert state.perceived is None
    assert len(jax.tree.leaves(state)) == len(
        jax.tree.leaves((state.step, state.vehicle, state.pedestrian, state.foresight))
    )


def test_a_recording_says_what_was_perceived_and_who_is_parked(hiding, scenarios):
    policies = {"driver": RouteFollower(), "pedestrian": AlwaysGo()}
    recorded = play(hiding, policies, scenarios, jax.random.split(jax.random.key(77), BATCH))
    now, age = recorded.perceived, recorded.last_seen_age
    assert 0.1 < now.mean() < 0.9
    for place, last in ((recorded.ped_x, recorded.last_seen_x), (recorded.ped_y, recorded.last_seen_y)):
        np.testing.assert_allclose(last[now], place[now], atol=1e-4)  # rounded otherwise if worked out twice
        kept = ~now[1:]
        np.testing.assert_array_equal(last[1:][kept], last[:-1][kept])
    assert (age[now] == 0).all() and (age[~now] > 0).all()
    slots = np.asarray(hiding.world.maps.slots)[0]
    for boxes, parked in zip(recorded.parked, np.asarray(scenarios.parked).T, strict=True):
        np.testing.assert_array_equal(boxes[parked], slots[parked])
        assert np.isnan(boxes[~parked]).all()
    some = part_of(recorded, frames=7, episodes=slice(3))
    assert some.perceived.shape == (7, 3, RULES.pedestrians)
    assert some.parked.shape == (3, *slots.shape)


def test_where_everybody_is_perceived_nothing_of_it_is_recorded(street):
    keys = jax.random.split(jax.random.key(77), 4)
    recorded = play(street, {"driver": RouteFollower(), "pedestrian": AlwaysGo()}, passersby.drawn(street, 4), keys)
    some = part_of(recorded, frames=2, episodes=slice(1))
    for one in (recorded, some):
        assert one.parked is one.perceived is one.last_seen_x is one.last_seen_y is one.last_seen_age is None
