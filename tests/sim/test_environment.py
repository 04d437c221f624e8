"""`step` is a function, of any batch, on any of several maps; traced once."""

from __future__ import annotations

import tomllib
from importlib import resources

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk import SimConfig, Street
from jaxwalk.evaluation import with_jaywalk_multiplier
from jaxwalk.interfaces import Environment
from sim.maps import rearranged, rectangles, turned, write
from sim.play import (
    ENVIRONMENTS,
    TRACES,
    actions,
    columns,
    draw,
    everything,
    everything_once,
    inside,
    play,
    random_actions,
    reset,
    with_car,
)

CLOSE = {"rtol": 1e-5, "atol": 1e-5}


def copied(tree):
    return jax.tree.map(lambda x: np.array(x), tree)


def assert_same(a, b, **tolerance):
    for x, y in zip(jax.tree.leaves(a), jax.tree.leaves(b), strict=True):
        if tolerance and np.asarray(x).dtype.kind == "f":
            np.testing.assert_allclose(x, y, **tolerance)
        else:
            np.testing.assert_array_equal(x, y)


def test_it_is_an_environment(street):
    assert isinstance(street, Environment)
    assert street.roles["driver"].action.size == 2
    assert street.roles["pedestrian"].agents == (12,)
    assert street.roles["pedestrian"].action.n == 2


def test_a_step_is_a_function(paid_street, scenarios, midway):
    chosen = actions((0.7, -0.2))
    before = copied((paid_street, scenarios, midway, chosen))
    first = copied(everything(paid_street, scenarios, midway, chosen))
    second = copied(everything(paid_street, scenarios, midway, chosen))
    assert_same(first, second)
    assert_same(before, (paid_street, scenarios, midway, chosen))


def test_a_scenario_can_be_played_again(street, scenarios, driven):
    chosen, played = driven
    assert_same(play(street, scenarios, *chosen), played)


def test_the_step_after_is_like_the_step_before(paid_street, scenarios, midway):
    """Same structure, shapes and types: so that scans work, and nothing is traced twice."""
    after, *_ = everything(paid_street, scenarios, midway, actions())
    kinds = [jax.tree.map(lambda x: (x.shape, x.dtype), s) for s in (reset(paid_street, scenarios), midway, after)]
    assert kinds[0] == kinds[1] == kinds[2]


@pytest.fixture(scope="module")
def batched(paid_street, scenarios, midway):
    """A batch in motion: scenarios, states, actions and what a step brings."""
    random = np.random.default_rng(8)
    state = with_car(midway, speed=random.uniform(0, 8, ENVIRONMENTS))
    drive, go = random.uniform(-1, 1, (2, ENVIRONMENTS)), random.integers(2, size=(12, ENVIRONMENTS))
    chosen = actions(drive, go)
    return (scenarios, state, chosen), everything(paid_street, scenarios, state, chosen)


def stepped(result):
    """What may be compared: what people think ahead is no matter of theirs alone."""
    _, outcome, seen, view = result
    return outcome, seen, view


def test_a_batch_is_its_episodes(paid_street, batched):
    """To 1e-5: compiled for one episode, sums may be rounded in another order."""
    inputs, result = batched
    for env in range(0, ENVIRONMENTS, 17):
        single = everything_once(paid_street, *columns(inputs, env))
        assert_same(stepped(single), columns(stepped(result), env), **CLOSE)


@pytest.mark.long
def test_two_batch_axes_are_one(paid_street, batched):
    inputs, result = batched

    def fold(tree):
        return jax.tree.map(lambda x: jnp.reshape(x, (*x.shape[:-1], 16, 16)), tree)

    assert_same(stepped(everything_once(paid_street, *fold(inputs))), fold(stepped(result)), **CLOSE)


def test_each_function_is_traced_once(paid_street, scenarios, midway, batched):
    state = midway
    for k in range(3):
        street = with_jaywalk_multiplier(paid_street, k / 2)
        state, *_ = everything(street, scenarios, state, actions((0.1 * k, 0.0)))
    assert TRACES
    assert max(TRACES.values()) == 1, TRACES


@pytest.fixture(scope="module")
def three_maps(tmp_path_factory):
    """The paper's map, one with more of everything, and the paper's turned by 90 degrees."""
    folder = tmp_path_factory.mktemp("maps")
    paper = tomllib.loads(resources.files("jaxwalk.maps").joinpath("paper.toml").read_text())
    return Street.create(
        ["paper", write(folder / "larger.toml", rearranged(paper)), write(folder / "turned.toml", turned(paper))]
    )


@pytest.fixture(scope="module")
def on_three_maps(three_maps, scenarios):
    """A third of the scenarios on each map, with random actions."""
    numbers = np.arange(ENVIRONMENTS) % 3
    goals = np.array(scenarios.goals)
    goals[0] = np.where(numbers == 1, 34, goals[0])  # a waypoint of the larger map only
    where = eqx.tree_at(lambda s: (s.map, s.goals), scenarios, (numbers.astype(np.int32), goals))
    return numbers, play(three_maps, where, *random_actions(0))


def test_padding_changes_no_result(on_three_maps, driven):
    """A map among others, and episodes on others beside it: to 1e-4, the look-ups are compiled in another way."""
    numbers, played = on_three_maps
    _, alone = driven
    assert_same(columns(played, numbers == 0), columns(alone, numbers == 0), rtol=1e-4, atol=1e-4)


def test_a_turned_world_is_the_same_world(on_three_maps, driven):
    numbers, played = on_three_maps
    _, straight = driven
    played, straight = columns(played, numbers == 2), columns(straight, numbers == 2)
    np.testing.assert_allclose(played["x"], 120 - straight["y"], atol=1e-3)
    np.testing.assert_allclose(played["y"], straight["x"], atol=1e-3)
    for name in ("crossing", "decisions", "goal", "arrivals", "going"):
        np.testing.assert_array_equal(played[name], straight[name])
    turned = {"car_x": 120 - straight["car_y"], "car_y": straight["car_x"], "car_cos": -straight["car_sin"]}
    turned |= {name: straight[name] for name in ("car_speed", "along")}
    same = np.all([np.abs(played[name] - turned[name]) < 1e-3 for name in turned], axis=0).all(axis=0)
    assert same.mean() > 0.9  # at a corner of a kerb, on the line between two cells, either of them may count


def test_the_scenario_names_its_map(three_maps, on_three_maps):
    numbers, played = on_three_maps
    for number in range(3):
        x, y = played["x"][..., numbers == number], played["y"][..., numbers == number]
        ground = np.concatenate([rectangles(kind, three_maps.maps[number]) for kind in ("sidewalks", "roads")])
        assert inside(ground, x, y, margin=-1e-3).all()
        assert (x.max() > 125) == (number == 1)
    drawn = np.asarray(draw(three_maps, 1, 0, 0).map)
    assert np.bincount(drawn, minlength=3).min() > 60


@pytest.mark.parametrize(
    "config",
    [SimConfig(pedestrians=1, dt=0.05), SimConfig(pedestrians=48)],
    ids=["one pedestrian and short steps", "48 pedestrians"],
)
def test_extreme_configurations(config):
    street = Street.create(config=config, jaywalk_multiplier=4.0, driver_weights={"closeness": 1.0})
    looks = [("driver", "paper"), ("driver", "route"), ("pedestrian", "paper")]

    def episode(street, key):
        scenario = street.draw(key)

        def body(state, _):
            go = jnp.ones((config.pedestrians,), jnp.int32)
            after, _ = street.step(scenario, state, {"driver": jnp.array([1.0, 0.1]), "pedestrian": go})
            seen = [street.observe(scenario, state, street.view(role, name)) for role, name in looks]
            return after, ([*seen, street.global_state(scenario, state)], after.pedestrian.x, after.vehicle.speed)

        return scenario, *jax.lax.scan(body, street.reset(scenario), length=100)

    scenario, state, (seen, x, speed) = jax.jit(episode)(street, jax.random.key(0))
    assert [look.shape[1] for look in seen] == [34, len(seen[1][0]), 20, 10 + 4 * config.pedestrians]
    for look in seen:
        assert np.isfinite(look).all()
        assert np.abs(look).max() < 4
    stride = config.dt * (1 + scenario.traits[1])
    assert (np.abs(np.diff(x, axis=0)) <= np.asarray(stride) + 1e-4).all()
    assert speed[0] == pytest.approx(3 * config.dt, rel=1e-5)
    assert state.step == 100
    absent = max(0, 6 - config.pedestrians)  # they stand 60 m ahead
    for look in seen[:2]:
        people = np.asarray(look[:, -24:]).reshape(100, 6, 4)
        assert (people[:, 6 - absent :] == [1, 0, 0, 0]).all()
        assert (people[:, : 6 - absent] != [1, 0, 0, 0]).any(axis=-1).all()
    if config.pedestrians == 1:
        np.testing.assert_array_equal(np.hypot(*np.moveaxis(seen[2][:, -2:], 1, 0)), 1)


@pytest.mark.parametrize(
    "wrong",
    [{"dt": 0.0}, {"pedestrians": 0}, {"max_speed": -1.0}, {"fastest_walk": 0.5}, {"offroad_speed": 2.0},
     {"horizon": 0}, {"max_steering": 1.6}, {"goal_spacing": -1.0}, {"dt": float("nan")}],
    ids=str,
)  # fmt: skip
def test_impossible_configurations_are_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        SimConfig(**wrong)


@pytest.mark.parametrize("multiplier", [-0.1, float("nan")])
def test_a_negative_multiplier_is_refused(multiplier):
    with pytest.raises(ValueError, match="jaywalk_multiplier must be a finite number of 0 or more"):
        Street.create(jaywalk_multiplier=multiplier)
