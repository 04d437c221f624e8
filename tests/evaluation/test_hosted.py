"""Drivers that are not JAX, in the same game."""

from __future__ import annotations

from itertools import pairwise

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.evaluation import Stopped, evaluate, evaluate_grid, play
from jaxwalk.evaluation.interventions import Brake, TakeOver
from jaxwalk.metrics import OUTCOMES
from jaxwalk.policies import AlwaysGo
from jaxwalk.policies.host import DriverError, HostDriver
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.observation import part
from jaxwalk.sim.sim_config import SimConfig

BATCH = 16  # as in all of this folder
ROUTE = part("driver", "route", "route")


class Follower:
    """The route-follower in NumPy, which counts its steps since the batch began."""

    observes = "route"

    def __init__(self, fails=None):
        self.step, self.batches, self.fails = 0, 0, fails

    def reset(self, episodes):
        self.step, self.batches = 0, self.batches + 1

    def act(self, observation):
        self.step += 1
        ahead, left = 2.5 * observation[:, ROUTE][:, :2].T  # the first point of the route [m]
        reach = np.maximum(ahead**2 + left**2 + SimConfig.wheelbase * ahead, 1e-3)
        angle = np.arctan(2 * SimConfig.wheelbase * left / reach)
        action = np.stack([np.ones_like(angle), np.clip(angle / SimConfig.max_steering, -1, 1)], axis=1)
        return action if self.fails is None else self.fails(self, action)


def hosted(fails=None):
    return HostDriver("mine", Follower(fails), observes="route")


def test_it_plays_as_the_same_driver_in_jax_does(street, driver, undecided):
    scenarios, keys = Drawn(street, 7).take(np.arange(BATCH))
    native = play(street, {"driver": driver, "pedestrian": undecided}, scenarios, keys)
    asked = play(street, {"driver": hosted(), "pedestrian": undecided}, scenarios, keys)
    for name in ("length", "goal", "collision", "scenario", "decisions"):
        np.testing.assert_array_equal(getattr(asked, name), getattr(native, name), err_msg=name)
    for name in ("car_x", "car_speed", "car_acceleration", "ped_x"):
        np.testing.assert_allclose(getattr(asked, name), getattr(native, name), atol=1e-3, err_msg=name)


@pytest.mark.long
def test_every_batch_is_its_own_although_two_are_under_way(street, rows, undecided):
    """A memory that mixed batches would count on, or wrongly."""
    steps = []

    def note(driver, action):
        steps.append(driver.step)
        return action

    mine = hosted(note)
    found = evaluate(street, {"driver": mine, "pedestrian": undecided}, Drawn(street, 7, 40), batch=BATCH)
    begins = np.flatnonzero(np.array(steps) == 1)
    assert len(begins) == 3  # batches
    assert all(later in (1, now + 1) for now, later in pairwise(steps))
    np.testing.assert_array_equal(found[OUTCOMES].goal, rows[OUTCOMES].goal)
    np.testing.assert_array_equal(found[OUTCOMES].collision, rows[OUTCOMES].collision)
    assert mine.steps_made == len(steps)


@pytest.mark.long
def test_its_cost_is_in_its_cell_and_in_no_other(street, driver, undecided):
    results, _ = evaluate_grid(
        street, {"mine": hosted(), "jax": driver}, {"undecided": undecided}, Drawn(street, 7, BATCH), batch=BATCH
    )
    assert results.cell("mine", "undecided").as_dict()["driver_ms_per_step"] > 0
    assert "driver_ms_per_step" not in results.cell("jax", "undecided").as_dict()


def test_a_failure_names_scenario_and_step_and_keeps_whole_batches(street, driver, undecided):
    def fails(mine, action):
        if mine.batches == 2 and mine.step == 6:
            action[3:5, 1] = np.nan
        return action

    with pytest.raises(Stopped, match=r"mine: act returned \[1 nan\].*\(scenario (19|35), step 5\)") as stopped:
        evaluate_grid(
            street, {"jax": driver, "mine": hosted(fails)}, {"undecided": undecided},
            Drawn(street, 7, 40), batch=BATCH,
        )  # fmt: skip
    kept = {pair: rows.episodes for pair, rows in stopped.value.rows.items()}
    # of two batches that wait, either's turn may come; after a failure the other is refused
    assert kept == {("jax", "undecided"): 40, ("mine", "undecided"): BATCH}


def test_a_failure_of_a_whole_batch_names_its_first_scenario(street):
    def fails(mine, action):
        raise RuntimeError("no fuel")

    scenarios, keys = Drawn(street, 7).take(np.arange(BATCH))
    message = r"mine: act raised RuntimeError: no fuel \(test_hosted.py, line \d+\) \(scenario 100 and 15 others"
    with pytest.raises(DriverError, match=message + r", played together, step 0\)"):
        play(
            street, {"driver": hosted(fails), "pedestrian": AlwaysGo()}, scenarios, keys, numbers=100 + np.arange(BATCH)
        )


def test_what_it_answers_for_an_episode_that_has_ended_does_not_matter(street, undecided):
    scenarios, keys = Drawn(street, 7).take(np.arange(BATCH))
    until = np.where(np.arange(BATCH) == 2, 10, 20)

    def fails(mine, action):
        action[2] = np.nan if mine.step > 10 else action[2]
        return action

    played = play(street, {"driver": hosted(fails), "pedestrian": undecided}, scenarios, keys, until=until)
    np.testing.assert_array_equal(played.length, until)


def test_an_intervention_changes_its_actions(street, undecided):
    scenarios, keys = Drawn(street, 7).take(np.arange(BATCH))
    until = np.full(BATCH, 20)
    brake = Brake(hosted(), jnp.full(BATCH, 10))
    played = play(street, {"driver": brake, "pedestrian": undecided}, scenarios, keys, until=until)
    assert (played.car_acceleration[1:11] > 0).all()
    assert (played.car_acceleration[11:] < 0).all()


def test_two_of_them_are_refused(street, undecided):
    """Only one is asked, and its answer would stand for the other's too."""
    scenarios, keys = Drawn(street, 7).take(np.arange(BATCH))
    other = HostDriver("yours", Follower(), observes="paper")
    both = TakeOver(hosted(), other, jnp.full(BATCH, 10))
    with pytest.raises(ValueError, match="one driver that isn't written in JAX, not mine and yours"):
        play(street, {"driver": both, "pedestrian": undecided}, scenarios, keys)
