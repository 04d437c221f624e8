"""Replays with one thing changed: everything stays as it was until the change, which is the one that was asked for."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from evaluation.blind import BLIND, BLIND_ONE, STANDING, WALKERS
from jaxwalk.evaluation import play
from jaxwalk.evaluation.interventions import Brake, Since, TakeOver, Wait, on_the_crosswalk, with_changes
from jaxwalk.metrics import OUTCOMES
from jaxwalk.policies import Oracle
from jaxwalk.policies.careful_human import CarefulHuman
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.crossing_kind import CROSSWALK, JAYWALK

BATCH = 16


@pytest.fixture(scope="module")
def batch(often):
    return Drawn(often, 7).take(np.arange(BATCH))


@pytest.fixture(scope="module")
def played(often, batch):
    return play(often, BLIND_ONE, *batch)


def frames_before(trajectory, last):
    """All numbers of the frames 0 .. last of each episode; NaN after it."""
    moving = [x for name, x in vars(trajectory).items() if name.startswith(("car_", "ped_"))]
    flat = np.concatenate([x.reshape(*x.shape[:2], -1) for x in moving], axis=2)
    kept = np.arange(len(flat))[:, None, None] <= np.asarray(last)[:, None]
    return np.where(kept, flat, np.nan)[: max(last) + 1]


def assert_same_until(last, one, other):
    """Two programs may round differently in the last bits, and do with the oldest JAX."""
    np.testing.assert_allclose(frames_before(one, last), frames_before(other, last), rtol=0, atol=1e-4)


def test_scenarios_are_chosen_by_number(street, batch):
    numbers = np.array([9, 3, 3, 15])
    chosen, keys = Drawn(street, 7).take(numbers)
    for one, every in zip(jax.tree.leaves(chosen), jax.tree.leaves(batch[0]), strict=True):
        np.testing.assert_array_equal(one, every[..., numbers])
    assert (keys == batch[1][numbers]).all()


def test_a_place_in_the_batch_changes_nothing_to_the_last_bit(often, played):
    numbers = np.arange(BATCH)[::-1]
    again = play(often, {"driver": BLIND, "pedestrian": WALKERS}, *Drawn(often, 7).take(numbers))
    for name, x in vars(played).items():
        if np.ndim(x) and name != "scenario":
            episode = 0 if len(x) == BATCH else 1
            np.testing.assert_array_equal(getattr(again, name), np.flip(x, axis=episode), err_msg=name)


def test_people_who_toss_coins_toss_the_same_ones_again(street, driver, undecided, rows):
    chosen = np.resize(np.flatnonzero(rows[OUTCOMES].collision), BATCH)
    again = play(street, {"driver": driver, "pedestrian": undecided}, *Drawn(street, 7).take(chosen))
    assert again.collision.all()
    np.testing.assert_array_equal(again.length, rows[OUTCOMES].steps[chosen])


def test_an_episode_can_be_stopped(often, batch, played):
    until = np.arange(20, 20 + 5 * BATCH, 5)
    stopped = play(often, {"driver": BLIND, "pedestrian": WALKERS}, *batch, until=until)
    np.testing.assert_array_equal(stopped.length, np.minimum(played.length, until))
    np.testing.assert_array_equal(stopped.collision, played.collision & (played.length <= until))
    np.testing.assert_array_equal(stopped.goal, played.goal & (played.length <= until))
    assert (stopped.length < played.length).any()


def test_who_is_to_wait_waits_and_nobody_else(often, batch, played):
    ped, begin = np.arange(BATCH) % 12, 10 + np.arange(BATCH)
    until = begin + 20
    waiting = Wait(WALKERS, jnp.asarray(ped), jnp.asarray(begin))
    changed = play(often, {"driver": BLIND, "pedestrian": waiting}, *batch, until=until)
    assert_same_until(begin, changed, played)
    for episode, last in enumerate(changed.length):
        going = changed.going[: last + 1, episode]
        assert going[: begin[episode] + 1, ped[episode]].all()
        assert not going[begin[episode] + 1 :, ped[episode]].any()
        assert np.delete(going, ped[episode], axis=1).all()


def test_the_car_brakes_and_steers_on(often, batch, played):
    begin = 20 + np.arange(BATCH)
    brakes = {"driver": Brake(BLIND, jnp.asarray(begin)), "pedestrian": WALKERS}
    changed = play(often, brakes, *batch, until=begin + 60)
    assert_same_until(begin, changed, played)
    under_way = changed.length > begin
    assert under_way.sum() > 10
    for episode in np.flatnonzero(under_way):
        assert (changed.car_acceleration[begin[episode] + 1 : changed.length[episode] + 1, episode] == -3).all()
    stood = changed.length == begin + 60
    assert (changed.car_speed[-1][stood] == 0).all()


def test_a_driver_takes_over(often, batch, played):
    begin = jnp.zeros(BATCH, jnp.int32)
    other = play(often, {"driver": STANDING, "pedestrian": WALKERS}, *batch)
    at_once = play(often, {"driver": TakeOver(STANDING, BLIND, begin), "pedestrian": WALKERS}, *batch)
    np.testing.assert_array_equal(at_once.length, played.length)
    assert_same_until(played.length, at_once, played)
    later = play(often, {"driver": TakeOver(STANDING, BLIND, begin + 30), "pedestrian": WALKERS}, *batch)
    before = np.minimum(other.length, 30)
    assert_same_until(before, later, other)
    assert (later.car_acceleration[31:40, later.length > 40] == 3).all()


def test_one_crossing_is_made_on_the_crosswalk(often, batch):
    scenarios, keys = batch
    before = play(often, {"driver": STANDING, "pedestrian": WALKERS}, scenarios, keys)
    jaywalks = (before.crossing == JAYWALK).any(axis=0)
    ped = jaywalks.argmax(axis=1)
    episode = np.flatnonzero(jaywalks.any(axis=1))
    when = (before.crossing[:, np.arange(BATCH), ped] == JAYWALK).argmax(axis=0)
    number = before.decisions[when, np.arange(BATCH), ped]
    after = play(often, {"driver": STANDING, "pedestrian": WALKERS}, on_the_crosswalk(scenarios, ped, number - 1), keys)
    assert len(episode) == BATCH
    for i in episode[after.length == 500]:
        mine = after.decisions[:, i, ped[i]] == number[i]
        assert set(after.crossing[mine, i, ped[i]]) <= {0, CROSSWALK}
        assert CROSSWALK in after.crossing[mine, i, ped[i]]
        others = np.arange(12) != ped[i]
        np.testing.assert_array_equal(
            after.ped_x[: before.length[i], i, others], before.ped_x[: before.length[i], i, others]
        )


def test_every_change_is_the_same_program(street):
    """Only its arrays differ, so nothing is compiled anew."""
    ped = np.arange(BATCH)
    changes = Since(), Since(wait=ped), Since(brake=ped), Since(oracle=ped, human=0 * ped)
    shapes = [jax.eval_shape(lambda x: x, with_changes(street, BLIND_ONE, ped, since)) for since in changes]
    assert all(eqx.tree_equal(one, shapes[0]) for one in shapes)


@pytest.mark.long
def test_each_change_begins_at_its_step(often, batch, played):
    """All four are around the policies, and one of them starts: each as it does alone, and none before."""
    ped, begin = np.arange(BATCH) % 12, 10 + np.arange(BATCH)

    def changed(since, until):
        return play(often, with_changes(often, BLIND_ONE, ped, since), *batch, until=until)

    unchanged = changed(Since(), played.length)
    np.testing.assert_array_equal(unchanged.length, played.length)
    assert_same_until(played.length, unchanged, played)
    oracle, human = (with_limits(other, often.config) for other in (Oracle(), CarefulHuman()))
    alone = {
        "wait": {"pedestrian": Wait(WALKERS, jnp.asarray(ped), jnp.asarray(begin))},
        "brake": {"driver": Brake(BLIND, jnp.asarray(begin))},
        "oracle": {"driver": TakeOver(BLIND, oracle, jnp.asarray(begin))},
        "human": {"driver": TakeOver(BLIND, human, jnp.asarray(begin))},
    }
    until = begin + 20
    for change, policies in alone.items():
        one, other = changed(Since(**{change: begin}), until), play(often, BLIND_ONE | policies, *batch, until=until)
        assert_same_until(np.minimum(begin, one.length), one, unchanged)
        np.testing.assert_array_equal(one.length, other.length)
        assert_same_until(one.length, one, other)
        assert (frames_before(one, one.length) != frames_before(unchanged, one.length)[: len(one.car_x)]).any()
