from __future__ import annotations

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.acting import typed
from jaxwalk.evaluation import play, with_jaywalk_multiplier
from jaxwalk.evaluation.playing import begin, play_block
from jaxwalk.metrics import WAITING, measure, summarise
from jaxwalk.policies import DRIVERS, POPULATIONS, AlwaysGo, ConstantSpeed
from jaxwalk.policies.shields.shield_scene import Around
from jaxwalk.scenarios import Drawn, Scripted
from jaxwalk.scenarios.crash_file import load_crash_suite
from jaxwalk.sim import pedestrian, prediction
from jaxwalk.sim.environment import Street
from jaxwalk.sim.observation import Observation, part
from jaxwalk.sim.sim_config import SimConfig

HORIZON = 110  # some arrive earlier, some do not; and it ends within a block of steps


@pytest.fixture(scope="module")
def short():
    """A street with short episodes."""
    return Street.create(config=SimConfig(horizon=HORIZON))


@pytest.fixture(scope="module")
def batch(short):
    return Drawn(short, 5).take(np.arange(16))


@pytest.fixture(scope="module")
def played(short, driver, undecided, batch):
    return play(short, {"driver": driver, "pedestrian": undecided}, *batch)


def per_frame(trajectory):
    once = ("touched", "jaywalking_tendency")
    return {name: x for name, x in vars(trajectory).items() if np.ndim(x) >= 2 and name not in once}


def types_of(tree):
    """Shapes and types of arrays, by their places; weak types count as others."""
    found = jax.tree_util.tree_leaves_with_path(tree)
    return {jax.tree_util.keystr(path): (x.shape, x.dtype, getattr(x, "weak_type", False)) for path, x in found}


def check_types(street, policies, batch):
    """The next block of steps goes on from what a block ends with: by the same program, if types are the same."""
    setup, game, _ = begin(street, policies, *batch)
    after, _ = eqx.filter_eval_shape(play_block, setup, game, 1)
    assert types_of(after) == types_of(game)


@pytest.mark.parametrize("people", POPULATIONS)
def test_whichever_people_walk_the_second_block_is_no_other_program(short, batch, people):
    check_types(short, {"driver": ConstantSpeed(), "pedestrian": POPULATIONS[people]()}, batch)


@pytest.mark.parametrize("name", ["careful-human", "fuzzy-safety", "crosswalk-yield", "belief-planner"])
def test_whichever_driver_remembers_neither(short, batch, name):
    check_types(short, {"driver": DRIVERS[name](), "pedestrian": AlwaysGo()}, batch)


def test_arrays_get_types_of_their_own_and_all_else_stays():
    tree = {"key": jax.random.key(1), "none": None, "number": 2.0, "weak": jnp.full(3, 2.0), "own": jnp.zeros(2, int)}
    found = typed(tree)
    assert (
        (found["none"], found["number"]) == (None, 2.0) and found["key"] is tree["key"] and found["own"] is tree["own"]
    )
    assert tree["weak"].weak_type and not found["weak"].weak_type
    np.testing.assert_array_equal(found["weak"], np.full(3, 2, np.float32))


def test_of_scripted_people_neither():
    suite = load_crash_suite("euro-ncap-style")
    source = Scripted.of(replace(suite, tests=suite.tests[:1]), "a test")
    check_types(source.street, {"driver": ConstantSpeed(), "pedestrian": AlwaysGo()}, source.take(np.arange(2)))


def test_frames_are_those_of_stepping_by_hand(short, driver, undecided, batch, played):
    scenarios, keys = batch

    @eqx.filter_jit
    def by_hand(short, scenarios, state, memory):
        key_of = jax.vmap(jax.random.split)(jax.vmap(jax.random.fold_in)(keys, 1 + state.step))
        drive, _ = driver.act(key_of[:, 0], None, short.observe(scenarios, state, short.view("driver", "route")))
        go, memory = undecided.act(
            key_of[:, 1], memory, short.observe(scenarios, state, short.view("pedestrian", "paper"))
        )
        state, outcome = short.step(scenarios, state, {"driver": drive, "pedestrian": go})
        car, people = state.vehicle, state.pedestrian
        seen = {
            "car_x": car.x, "car_speed": car.speed, "car_acceleration": car.acceleration, "ped_x": people.x,
            "ped_vx": pedestrian.velocity(short.world, scenarios, people)[0], "on_roadway": people.on_roadway,
            "going": people.going, "decisions": people.decisions, "at_kerb": pedestrian.at_kerb(short.world, people),
            "enters_roadway": pedestrian.enters_roadway(people),
            "predicted_miss": prediction.predicted_miss(short.world, scenarios, state)[0],
        }  # fmt: skip
        return state, memory, outcome.events, seen

    state, memory, under_way = short.reset(scenarios), undecided.init((12,), (16,)), np.ones(16, bool)
    for frame in range(1, played.length.max() + 1):
        state, memory, events, seen = by_hand(short, scenarios, state, memory)
        for name, now in seen.items():
            frames = getattr(played, name)[frame][under_way]
            np.testing.assert_allclose(frames, np.asarray(now).T[under_way], rtol=1e-5, atol=1e-4, err_msg=name)
        ends = under_way & np.asarray(events.goal | events.collision | events.timeout)
        np.testing.assert_array_equal(played.length[ends], frame)
        np.testing.assert_array_equal(played.goal[ends], events.goal[ends])
        np.testing.assert_array_equal(played.touched[ends], events.touched.T[ends])
        under_way &= ~ends
    assert not under_way.any()


class Careful(AlwaysGo):
    """Waits at the kerb if going now would bring the centres closer than 2.5 m."""

    view: Observation = eqx.field(static=True, default=Observation("pedestrian", "kerb"))

    def act(self, key, memory, observation):
        decides, miss = (observation[part("pedestrian", "kerb", name).start] for name in ("decides", "miss"))
        return 1 - ((decides > 0) & (miss < 0.25)).astype(jnp.int32), memory


def test_who_waits_in_danger_alone_is_measured_so(short, driver, batch):
    found = summarise(measure(play(short, {"driver": driver, "pedestrian": Careful()}, *batch)))[WAITING]
    assert (found.danger.value, found.harmless.value) == (1, 0)
    assert min(found.danger.count, found.harmless.count) > 10
    assert found.longest_stand == 0


def test_frame_0_is_the_reset(short, batch, played):
    start = short.reset(batch[0])
    np.testing.assert_array_equal(played.car_x[0], start.vehicle.x)
    np.testing.assert_array_equal(played.ped_y[0], start.pedestrian.y.T)
    np.testing.assert_array_equal(played.jaywalking_tendency, batch[0].traits[0].T)
    assert (played.car_speed[0] == 0).all()
    assert (played.ped_vx[0] == 0).all()
    assert played.going[0].all()


def test_arrays_are_numpy_in_the_order_frame_episode_pedestrian(played):
    frames = played.length.max() + 1
    for name, x in per_frame(played).items():
        assert isinstance(x, np.ndarray)
        assert x.shape == ((frames, 16) if name.startswith("car_") else (frames, 16, 12)), name


def test_episodes_end_in_every_way_and_then_repeat_their_last_frame(played):
    timeout = ~played.goal & ~played.collision
    assert played.goal.any()
    assert played.collision.any()
    assert timeout.any()
    assert not (played.goal & played.collision).any()
    assert (played.length[timeout] == HORIZON).all()
    assert (played.touched.any(axis=1) == played.collision).all()
    for name, x in per_frame(played).items():
        for episode, last in enumerate(played.length):
            assert (x[last:, episode] == x[last, episode]).all(), name


def test_an_episode_alone_is_the_same_as_in_a_batch(short, driver, undecided, batch, played):
    scenarios, keys = batch
    third = jax.tree.map(lambda x: x[..., 3:4], scenarios)
    alone = play(short, {"driver": driver, "pedestrian": undecided}, third, keys[3:4], numbers=np.array([3]))
    assert alone.scenario.tolist() == [3]
    assert alone.length[0] == played.length[3]
    for name, x in per_frame(alone).items():
        np.testing.assert_allclose(x[:, 0], getattr(played, name)[: len(x), 3], rtol=1e-5, atol=1e-4, err_msg=name)


def test_what_policies_draw_depends_on_their_keys(short, driver, undecided, batch, played):
    scenarios, keys = batch
    again = play(short, {"driver": driver, "pedestrian": undecided}, scenarios, keys)
    other = play(short, {"driver": driver, "pedestrian": undecided}, scenarios, keys[::-1])
    for name, x in per_frame(again).items():
        np.testing.assert_array_equal(x, getattr(played, name))
    assert (other.going[1] != played.going[1]).any()


def test_another_multiplier_or_other_weights_compile_nothing_anew(street):
    traces = []

    class Counted(ConstantSpeed):
        weight: jax.Array = eqx.field(default_factory=lambda: jnp.ones(()), kw_only=True)

        def act(self, key, memory, observation):
            traces.append(1)
            action, memory = super().act(key, memory, observation)
            return action * self.weight, memory

    scenarios, keys = Drawn(street, 5).take(np.arange(16))
    play(street, {"driver": Counted(), "pedestrian": AlwaysGo()}, scenarios, keys)
    first = len(traces)
    for multiplier in (0.0, 0.1, 1.0):
        weaker = Counted(weight=jnp.float32(0.5))
        other = with_jaywalk_multiplier(street, multiplier)
        play(other, {"driver": weaker, "pedestrian": AlwaysGo()}, scenarios, keys)
    assert len(traces) == first > 0


def test_a_batch_that_does_not_fit_is_refused(short, driver, undecided, batch):
    scenarios, keys = batch
    with pytest.raises(ValueError, match="one key for each"):
        play(short, {"driver": driver, "pedestrian": undecided}, scenarios, keys[:3])


class Watches(eqx.Module):
    """Drives full throttle, and remembers how far ahead the nearest person was last."""

    view: Around = eqx.field(static=True, default=Around())

    def init(self, agents, batch):
        return jnp.zeros(batch)

    def act(self, key, memory, scene):
        return jnp.stack([jnp.ones_like(memory), jnp.zeros_like(memory)]), jnp.abs(scene.people.ahead).min(axis=0)


def test_nobody_is_there_any_more_once_an_episode_has_ended(short, undecided, batch):
    """A shield would search for a way around them in vain, step after step, until the longest episode has ended."""
    setup, game, _ = begin(short, {"driver": Watches(), "pedestrian": undecided}, *batch)
    game, _ = play_block(setup, game, 25)
    assert not game.ended.all()
    assert (game.memory["driver"][0] < 100).all()
    game, _ = play_block(setup, game, HORIZON)
    assert game.ended.all()
    assert (game.memory["driver"][0] == prediction.AWAY).all()
