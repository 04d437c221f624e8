"""Policies whose actions aren't in their spaces end what plays them, in words."""

from __future__ import annotations

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from evaluation.test_hosted import hosted
from jaxwalk.evaluation import ActionError, Stopped, evaluate, evaluate_grid, named, play
from jaxwalk.evaluation.interventions import Wait
from jaxwalk.policies import AlwaysGo, RouteFollower, load_policy, shipped_policy
from jaxwalk.scenarios import Drawn

BATCH = 16  # as in all of this folder


class From(eqx.Module):
    """Follows the route; from a step on, its action in every other episode is that of ``action``."""

    action: jax.Array
    step: jax.Array
    view: object = eqx.field(static=True, default=RouteFollower().view)

    def init(self, agents, batch):
        return jnp.zeros(batch, jnp.int32)

    def act(self, key, memory, observation):
        sound, _ = RouteFollower().act(key, None, observation)
        breaks = (memory >= self.step) & (jnp.arange(memory.size) % 2 == 1)
        return jnp.where(breaks, self.action[:, None], sound), memory + 1


class Chooser(AlwaysGo):
    """Somebody chooses what is no choice."""

    choice: jax.Array = eqx.field(default_factory=lambda: jnp.int32(2), kw_only=True)

    def act(self, key, memory, observation):
        go, memory = super().act(key, memory, observation)
        return go.at[3, 5:].set(self.choice), memory


def begin(street):
    return Drawn(street, 7).take(np.arange(BATCH))


@pytest.mark.parametrize(
    ("action", "step", "message"),
    [
        ([0.5, np.nan], 0, r"driver: its action is \[0.5 nan\], not 2 numbers in \[-1, 1\] \(scenario 101, step 0\);"),
        ([-np.inf, 0], 0, r"driver: its action is \[-inf 0\], .* \(scenario 101, step 0\); the policy is broken"),
        ([1.5, 0], 7, r"driver: its action is \[1.5 0\], .* \(scenario 101, step 7\); the policy is broken"),
    ],
)
def test_a_drivers_action_names_scenario_and_step(street, action, step, message):
    policies = {"driver": From(jnp.array(action), jnp.int32(step)), "pedestrian": AlwaysGo()}
    with pytest.raises(ActionError, match=message):
        play(street, policies, *begin(street), numbers=100 + np.arange(BATCH))


def test_rounding_beyond_the_limits_is_no_failure(street):
    policies = {"driver": From(jnp.array([1 + 5e-5, -1.0]), jnp.int32(0)), "pedestrian": AlwaysGo()}
    assert play(street, policies, *begin(street), until=np.full(BATCH, 20)).length.max() == 20


@pytest.mark.parametrize("choice", [-1, 2])
def test_somebodys_choice_names_them_also_behind_an_intervention(street, driver, choice):
    people = Chooser(choice=jnp.int32(choice))
    wait = Wait(people, jnp.zeros(BATCH, jnp.int32), jnp.zeros(BATCH, jnp.int32))
    message = rf"pedestrian: its action is {choice}, not an integer in \[0, 2\) \(scenario 5, step 0, pedestrian 3\)"
    for policy in (people, wait):
        with pytest.raises(ActionError, match=message):
            play(street, {"driver": driver, "pedestrian": policy}, *begin(street))


def test_people_among_whom_a_hosted_driver_drives_are_checked_too(street):
    with pytest.raises(ActionError, match=r"pedestrian: its action is 2, .* \(scenario 5, step 0, pedestrian 3\)"):
        play(street, {"driver": hosted(), "pedestrian": Chooser()}, *begin(street), until=np.full(BATCH, 20))


def test_an_action_after_the_end_does_not_matter(street):
    until = np.full(BATCH, 7)
    policies = {"driver": From(jnp.array([np.nan, 0]), jnp.int32(7)), "pedestrian": AlwaysGo()}
    assert (play(street, policies, *begin(street), until=until).length == 7).all()


def test_a_comparison_names_the_policy_and_keeps_what_was_played(street, driver):
    broken = From(jnp.array([np.nan, 0]), jnp.int32(2))
    with pytest.raises(Stopped, match=r"^mine: its action is \[nan 0\].*\(scenario 1, step 2\)") as stopped:
        evaluate_grid(
            street, {"route": driver, "mine": broken}, {"always-go": AlwaysGo()}, Drawn(street, 7, 24), batch=BATCH
        )
    assert {pair: rows.episodes for pair, rows in stopped.value.rows.items()} == {("route", "always-go"): 24}
    with pytest.raises(Stopped, match=r"^crowd: its action is 2, not an integer"):
        evaluate_grid(street, {"route": driver}, {"crowd": Chooser()}, Drawn(street, 7, 24), batch=BATCH)


def test_the_name_is_that_of_the_role():
    error = ActionError("pedestrian", "is broken")
    with pytest.raises(ActionError, match="crowd: is broken"), named({"driver": "mine", "pedestrian": "crowd"}):
        raise error


def scaled(policy, by):
    with np.errstate(over="ignore"):
        network = jax.tree.map(lambda x: jnp.asarray(np.asarray(x) * np.float32(by)), policy.actor.network)
    return eqx.tree_at(lambda policy: policy.actor.network, policy, network)


@pytest.mark.parametrize(("role", "sample"), [("driver", False), ("driver", True), ("pedestrian", True)])
def test_networks_that_overflow_do_not_hide_it(street, role, sample):
    """At ee64c7f: 'collision 0.00, timeout 100.00' and a warning; people stood, since argmax of NaN is 0."""
    name = {"driver": "co-trained", "pedestrian": "learned"}[role]
    sound = {"driver": RouteFollower(), "pedestrian": AlwaysGo()}
    broken = scaled(load_policy(shipped_policy(role, name), role, sample=sample), 1e30)
    with pytest.raises(ActionError, match=rf"{role}: its action is (-1|\[.*nan.*\]), not "):
        evaluate(street, sound | {role: broken}, Drawn(street, 7, 8), batch=BATCH)
