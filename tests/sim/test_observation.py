"""What each role sees, and what the car must not."""

from __future__ import annotations

import equinox as eqx
import numpy as np
import pytest

from jaxwalk.evaluation import with_jaywalk_multiplier
from jaxwalk.sim.observation import OBSERVATIONS, Observation, bounds, part, size
from pytrees import as_numpy
from sim.play import ENVIRONMENTS, PEOPLE, SETS, actions, everything, goal, people, reset, with_car

DRIVER = [f"{role} {name}" for role, name in SETS if role == "driver"]


@pytest.fixture(scope="module")
def moving(scenarios, midway):
    """The state midway, with the car anywhere on the W-E road, at any speed."""
    random = np.random.default_rng(1)
    angle = random.uniform(-np.pi, np.pi, ENVIRONMENTS)
    return with_car(midway, x=random.uniform(5, 115, ENVIRONMENTS), y=random.uniform(53, 59, ENVIRONMENTS),
                    cos=np.cos(angle), sin=np.sin(angle), speed=random.uniform(0, 8.33, ENVIRONMENTS))  # fmt: skip


@pytest.fixture(scope="module")
def seen(paid_street, scenarios, moving):
    _, _, seen, _ = everything(paid_street, scenarios, moving, actions())
    return {name: np.asarray(x, float) for name, x in seen.items()}


@pytest.mark.parametrize(
    ("role", "name", "said"),
    [("driver", "nothing", "no observation set 'nothing' for the driver"), ("cyclist", "paper", "no role 'cyclist'")],
)
def test_what_does_not_exist_is_named(street, role, name, said):
    with pytest.raises(ValueError, match=said):
        Observation(role, name)
    with pytest.raises(ValueError, match=said):
        bounds(street.world, role, name)


def test_sizes(seen):
    assert seen["driver paper"].shape == (34, ENVIRONMENTS)
    assert seen["pedestrian paper"].shape == (20, PEOPLE, ENVIRONMENTS)
    assert seen["global"].shape == (58, ENVIRONMENTS)
    for role, name in SETS:
        assert len(seen[f"{role} {name}"]) == size(role, name)
    for x in seen.values():
        assert np.isfinite(x).all()
        assert np.abs(x).max() < 60  # scaled; the largest are distances to a route far away


def test_an_unknown_set_is_refused(street, scenarios, midway):
    with pytest.raises(ValueError, match="no observation set 'papers' for the driver; there are: paper, route"):
        street.observe(scenarios, midway, street.view("driver", "papers"))


def test_the_papers_car(street, scenarios, moving, seen):
    car, goal_xy = moving.vehicle, goal(street.world, scenarios)
    x, y, cos, sin, speed = (np.asarray(v, float) for v in (car.x, car.y, car.cos, car.sin, car.speed))
    dx, dy = np.asarray(goal_xy[0], float) - x, np.asarray(goal_xy[1], float) - y
    own = np.stack([x / 120, y / 120, cos, sin, speed / 8.33, (dx * cos + dy * sin) / 60, (dy * cos - dx * sin) / 60,
                    np.hypot(dx, dy) / 60])  # fmt: skip
    np.testing.assert_allclose(seen["driver paper"][:8], own, atol=1e-5)


def test_the_papers_pedestrian(scenarios, moving, seen):
    car, walkers = moving.vehicle, moving.pedestrian
    x, y = np.asarray(walkers.x, float), np.asarray(walkers.y, float)
    looked = seen["pedestrian paper"]
    np.testing.assert_allclose(looked[:2], np.stack([x, y]) / 120, atol=1e-5)
    speed = np.where(walkers.going, 1 + np.asarray(scenarios.traits[1]), 0)
    np.testing.assert_allclose(np.hypot(*looked[2:4]) * 2, speed, atol=1e-5)
    np.testing.assert_array_equal(looked[4:8], np.asarray(scenarios.traits, float))
    surface = np.stack([~walkers.on_roadway, walkers.on_roadway & walkers.on_crosswalk,
                        walkers.on_roadway & ~walkers.on_crosswalk])  # fmt: skip
    np.testing.assert_array_equal(looked[10:13], surface)
    assert (looked[10:13].sum(axis=0) == 1).all()
    np.testing.assert_allclose(looked[14:16] * 60, np.stack([car.x - x, car.y - y]), atol=1e-3)
    towards = np.stack([car.speed * car.cos, car.speed * car.sin])[:, None]
    np.testing.assert_allclose(looked[16:18] * 8.33 - towards, 0, atol=1e-4)
    away = np.hypot(x[None] - x[:, None], y[None] - y[:, None]) + np.where(np.eye(PEOPLE), np.inf, 0)[..., None]
    np.testing.assert_allclose(np.hypot(*looked[18:20]) * 60, np.minimum(away.min(axis=1), 60 * 2**0.5), atol=1e-3)


def test_the_critics_world(scenarios, moving, seen):
    world, walkers = seen["global"], moving.pedestrian
    np.testing.assert_allclose(world[:12], np.asarray(walkers.x) / 120, atol=1e-5)
    np.testing.assert_allclose(world[12:24], np.asarray(walkers.y) / 120, atol=1e-5)
    np.testing.assert_allclose(world[36:48], np.asarray(scenarios.traits[0]), atol=1e-6)
    np.testing.assert_allclose(world[52], np.asarray(moving.vehicle.speed) / 8.33, atol=1e-5)
    np.testing.assert_allclose(world[57], 1 - 150 / 500, atol=1e-5)


def nearest_by_sorting(state, scenario):
    """Relative positions and velocities of the nearest 6, by a stable sort: (person, number, env)."""
    car, walkers = state.vehicle, state.pedestrian
    cos, sin = np.asarray(car.cos, float), np.asarray(car.sin, float)
    dx, dy = np.asarray(walkers.x - car.x, float), np.asarray(walkers.y - car.y, float)
    order = np.argsort(dx**2 + dy**2, axis=0, kind="stable")[:6]
    speed = np.where(walkers.going, 1 + np.asarray(scenario.traits[1]), 0)
    vx, vy = speed * np.asarray(walkers.leg.cos), speed * np.asarray(walkers.leg.sin)
    turned = [dx * cos + dy * sin, dy * cos - dx * sin, vx * cos + vy * sin, vy * cos - vx * sin]
    return np.stack([np.take_along_axis(part, order, axis=0) for part in turned], axis=1)


@pytest.mark.parametrize("name", [name for name in DRIVER if name != "driver corridor"])  # the nearest ahead: its own
def test_the_nearest_six_are_those_of_a_sort(name, scenarios, moving, seen):
    scale = np.array([60, 60, 8.33, 8.33])[None, :, None]
    found = seen[name][part(*name.split(), "people")].reshape(6, 4, ENVIRONMENTS) * scale
    np.testing.assert_allclose(found, nearest_by_sorting(moving, scenarios), atol=1e-3)


def test_two_at_the_same_place_are_both_seen(paid_street, scenarios, moving):
    twins = np.repeat(np.arange(0, PEOPLE, 2), 2)
    scenario, state = people(scenarios, moving, twins)
    _, _, looked, _ = everything(paid_street, scenario, state, actions())
    found = np.asarray(looked["driver paper"], float)[-24:].reshape(6, 4, ENVIRONMENTS)
    scale = np.array([60, 60, 8.33, 8.33])[None, :, None]
    np.testing.assert_allclose(found * scale, nearest_by_sorting(state, scenario), atol=1e-3)
    np.testing.assert_array_equal(found[0::2], found[1::2])


def test_people_can_be_permuted(paid_street, scenarios, moving, seen):
    order = np.random.default_rng(2).permutation(PEOPLE)
    scenario, state = people(scenarios, moving, order)
    after, outcome, looked, _ = everything(paid_street, scenario, state, actions())
    for name in DRIVER:
        np.testing.assert_allclose(looked[name], seen[name], atol=1e-6)
    np.testing.assert_allclose(looked["pedestrian paper"], seen["pedestrian paper"][:, order], atol=1e-6)
    straight, unpermuted, _, _ = everything(paid_street, scenarios, moving, actions())
    np.testing.assert_array_equal(after.pedestrian.x, np.asarray(straight.pedestrian.x)[order])
    np.testing.assert_array_equal(
        outcome.terminated["pedestrian"], np.asarray(unpermuted.terminated["pedestrian"])[order]
    )


def test_traits_plans_and_draws_do_not_show(paid_street, scenarios, moving, seen):
    """All that a scenario holds about people but where they start and how fast they walk."""
    drawn = as_numpy(scenarios)
    traits = np.where(np.arange(len(drawn.traits))[:, None, None] == 1, drawn.traits, 1 - drawn.traits)
    hidden = eqx.tree_at(
        lambda s: (s.traits, s.goals, s.jaywalk_draw, s.zone_draw),
        scenarios,
        (traits, drawn.goals[::-1], 1 - drawn.jaywalk_draw, 1 - drawn.zone_draw),
    )
    _, _, looked, _ = everything(paid_street, hidden, moving, actions())
    for name in DRIVER:
        np.testing.assert_array_equal(looked[name], seen[name])


@pytest.mark.parametrize("change", ["multiplier", "goals"])
def test_what_people_have_in_mind_does_not_show(change, paid_street, scenarios):
    """Two worlds, alike but for what is decided and where people want to go: they look the same till people part."""
    other_street, other = paid_street, scenarios
    if change == "multiplier":
        other_street = with_jaywalk_multiplier(paid_street, 4.0)
    else:
        goals = np.asarray(scenarios.goals)
        goals = np.concatenate([goals[:1], np.roll(goals[1:], 1, axis=0)])
        other = eqx.tree_at(lambda s: s.goals, scenarios, goals)
    one = two = reset(paid_street, scenarios)
    secrets = 0
    for step in range(120):
        one, _, seen_one, view_one = everything(paid_street, scenarios, one, actions((0.2, 0.0)))
        two, _, seen_two, view_two = everything(other_street, other, two, actions((0.2, 0.0)))
        if step:  # observations are of the state before the step
            for name in DRIVER:
                np.testing.assert_array_equal(
                    np.asarray(seen_one[name])[:, alike], np.asarray(seen_two[name])[:, alike]
                )
        alike = np.ones(ENVIRONMENTS, bool)
        for name in ("x", "y", "vx", "vy"):
            alike &= (view_one[name] == view_two[name]).all(axis=0)
        differs = np.zeros(ENVIRONMENTS, bool)
        for name in ("crossing", "goal", "decisions", "arrivals", "at_kerb"):
            differs |= (view_one[name] != view_two[name]).any(axis=0)
        secrets += (alike & differs).sum()
    assert secrets > (100 if change == "multiplier" else 10)


def test_who_decides_at_the_kerb(paid_street, scenarios, midway):
    """The last metre before the roadway, on the leg that leads there, with the car within 40 m and not past."""
    random, walkers = np.random.default_rng(3), midway.pedestrian
    lead = random.choice([-0.5, 0.5], walkers.remaining.shape).astype(np.float32)  # from the leg's end to the roadway
    walkers = eqx.tree_at(
        lambda p: (p.leg.kerb_past_end, p.remaining),
        walkers,
        (lead, random.uniform(0, 3, lead.shape).astype(np.float32)),
    )
    state = eqx.tree_at(lambda s: s.pedestrian, midway, walkers)
    _, _, seen, _ = everything(paid_street, scenarios, state, actions())
    decides = np.asarray(seen["pedestrian kerb"][0], bool)
    to_kerb = lead + np.asarray(walkers.remaining)
    dx, dy = (np.asarray(of_all) - np.asarray(of_car) for of_all, of_car in
              ((walkers.x, midway.vehicle.x), (walkers.y, midway.vehicle.y)))  # fmt: skip
    ahead = dx * np.asarray(midway.vehicle.cos) + dy * np.asarray(midway.vehicle.sin)
    close = (np.hypot(dx, dy) < 40) & (ahead > -2.5)
    np.testing.assert_array_equal(decides, (lead < 0) & (to_kerb > 0) & (to_kerb <= 1.5) & close)
    assert 0 < decides.sum() < decides.size


@pytest.mark.parametrize(("role", "name"), [(role, name) for role in OBSERVATIONS for name in OBSERVATIONS[role]])
def test_every_feature_has_units(role, name):
    for feature in OBSERVATIONS[role][name]:
        assert feature.units and feature.size % len(feature.units) == 0, feature.name
