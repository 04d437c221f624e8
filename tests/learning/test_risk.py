"""Limits of costs: the controller and the advantage by hand, and games in which what pays also costs."""

from __future__ import annotations

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.acting import Nothing
from jaxwalk.learning import advantages, risk
from jaxwalk.learning.casting import shard_of
from jaxwalk.learning.checkpoint import restore, save
from jaxwalk.learning.config import CostLimit, RoleConfig, TrainConfig
from jaxwalk.learning.hyperparameters import hyperparameters
from jaxwalk.learning.mappo import init, update
from jaxwalk.learning.risk import fresh_multipliers
from jaxwalk.learning.turns import init_in_turns, update_in_turns
from learning import games
from learning.fined_games import HASTE, TOLL, made
from pytrees import the_same

LIMIT = CostLimit("fine", limit=0.5)
ROLE = RoleConfig(actor_hidden=(16,), critic_hidden=(16,), entropy=0.02, initial_std=0.3)
CONFIG = TrainConfig(
    roles={"driver": ROLE, "pedestrian": dataclasses.replace(ROLE, fixed=1.0)}, environments=64, steps=16,
    minibatches=4, updates=200, learning_rate=1e-3, anneal=True, discount=0.9, chunk_rows=10**6,
)  # fmt: skip


# Compiled as wholes: one operation after the other, each would be a program.
charge, constrained, controlled, measured, normalised, tracked = map(
    eqx.filter_jit,
    (risk.charge, risk.constrained, risk.controlled, risk.measured, advantages.normalised, risk.tracked),
)


def limited(*limits, **changes):
    """The configuration of a driver with these limits."""
    return games.with_roles(CONFIG, driver=dataclasses.replace(ROLE, limits=limits, **changes))


def fresh(limit=LIMIT):
    (multiplier,) = fresh_multipliers(limited(limit)).values()
    return multiplier


def test_three_steps_of_the_controller_by_hand():
    """Gains 0.1, 0.01 and 0.01, moving averages that keep 0.95, a limit of 0.5.

    A cost of 0.75 is 1.5 limits, an error of 0.5. I = 0.01 x 0.5 = 0.005; the mean error is 0.05 x 0.5 = 0.025; the
    mean cost 0.05 x 1.5 = 0.075, all of which is a rise: lambda = 0.0025 + 0.005 + 0.00075 = 0.00825.
    A cost of 5 counts as 2 limits, an error of 1. I = 0.015; mean error 0.95 x 0.025 + 0.05 = 0.07375; mean cost
    0.95 x 0.075 + 0.1 = 0.17125: lambda = 0.007375 + 0.015 + 0.0017125 = 0.0240875.
    A cost of 0 is an error of -1. I = 0.005; mean error 0.95 x 0.07375 - 0.05 = 0.0200625; mean cost 0.1626875:
    lambda = 0.00200625 + 0.005 + 0.001626875 = 0.008633125.
    """
    multiplier, found = fresh(), []
    for cost in (0.75, 5.0, 0.0):
        multiplier = controlled(LIMIT, multiplier, np.float32(cost))
        found.append(float(multiplier.value))
    np.testing.assert_allclose(found, [0.00825, 0.0240875, 0.008633125], rtol=1e-5)
    np.testing.assert_allclose(np.asarray(multiplier.earlier)[-3:], [0.075, 0.17125, 0.1626875], rtol=1e-5)


def test_the_rise_is_that_since_ten_updates_before():
    """With the derivative alone: in the first ten updates the whole mean cost is a rise, then what came since."""
    limit = dataclasses.replace(LIMIT, proportional=0.0, integral=0.0, derivative=1.0)
    multiplier, found = fresh(limit), []
    for _ in range(12):
        multiplier = controlled(limit, multiplier, np.float32(0.5))
        found.append(float(multiplier.value))
    level = 1 - 0.95 ** np.arange(1, 13)  # of a cost of one limit
    np.testing.assert_allclose(found[:10], level[:10], rtol=1e-5)
    np.testing.assert_allclose(found[10:], [level[10] - level[0], level[11] - level[1]], rtol=1e-4)


def test_a_multiplier_is_never_negative_and_unwinds_as_fast_as_it_winds_up():
    multiplier = fresh()
    for _ in range(30):
        multiplier = controlled(LIMIT, multiplier, np.float32(1e6))
    assert float(multiplier.integral) == pytest.approx(0.3, rel=1e-5)
    for _ in range(30):
        multiplier = controlled(LIMIT, multiplier, np.float32(0.0))
    assert float(multiplier.integral) == pytest.approx(0.0, abs=1e-6)
    for _ in range(30):
        multiplier = controlled(LIMIT, multiplier, np.float32(0.0))
    assert (float(multiplier.value), float(multiplier.integral)) == (0.0, 0.0)


def test_the_combined_advantage_by_hand():
    # (2 - 0.5 x 1) / 1.5 = 1 and (0 + 0.5 x 3) / 1.5 = 1
    of_reward, of_cost = np.float32([2, 0]), np.float32([1, -3])
    np.testing.assert_allclose(constrained(of_reward, [(np.float32(0.5), of_cost)]), [1.0, 1.0], rtol=1e-6)
    # two limits: (2 - 0.5 - 1.5 x 2) / 3 and (0 + 1.5 - 1.5 x 4) / 3
    other = np.float32(1.5), np.float32([2, 4])
    found = constrained(of_reward, [(np.float32(0.5), of_cost), other])
    np.testing.assert_allclose(found, [-0.5, -1.5], rtol=1e-6)
    # in units of the reward's advantage, whose deviation is 1: their mean goes, their size stays
    np.testing.assert_allclose(normalised(found, np.ones(2, np.float32), unit=of_reward), [0.5, -0.5], rtol=1e-6)


def test_a_tail_is_the_excess_over_its_threshold_by_hand():
    """Costs 0, 1, 4 and 8, the worst half of them 4 and 8, on average 6.

    With the threshold at 2, halfway between the 1 and the 4, the excesses are 2 and 6, and 2 + (2 + 6) / 4 / 0.5 = 6.
    """
    limit = CostLimit("fine", limit=10.0, tail=0.5, worth=3.0)
    multiplier = eqx.tree_at(lambda m: m.threshold, fresh(), jax.device_put(np.float32(2.0)))
    costs = np.float32([0, 1, 4, 8])
    np.testing.assert_allclose(charge(limit, multiplier, costs), [0, 0, 12, 36])
    mean, beyond = measured(limit, multiplier, costs, np.float32(4.0))
    assert (float(mean), float(beyond)) == (6.0, 0.5)
    plain = dataclasses.replace(limit, tail=0.0)
    np.testing.assert_allclose(charge(plain, fresh(), costs), 3 * costs)
    assert float(measured(plain, fresh(), costs, np.float32(4.0))[0]) == 13 / 4


def test_the_threshold_goes_where_the_tail_begins():
    """Steps of 0.05 limits: up with twice the tail beyond it or more, down with nobody, and never below 0."""
    limit = CostLimit("fine", limit=10.0, tail=0.75)
    moved = [float(tracked(limit, np.float32(2.0), np.float32(beyond))) for beyond in (0.25, 0.375, 0.5, 1.0, 0.0)]
    np.testing.assert_allclose(moved, [2.0, 2.25, 2.5, 2.5, 1.5])
    assert float(tracked(limit, np.float32(0.2), np.float32(0.0))) == 0.0


class Still(eqx.Module):
    """Pedestrians who wait."""

    view: Nothing = eqx.field(static=True, default=Nothing())

    def init(self, agents, batch):
        return jnp.zeros((*agents, *batch), jnp.int32)

    def act(self, key, memory, seen):
        return memory, memory


OTHERS = {"pedestrian": Still()}
QUICK = {"proportional": 1.0, "integral": 0.05, "derivative": 0.01}
"""Gains for trainings of 200 updates."""
AT_TIMES = limited(CostLimit("fine", limit=0.4, worth=0.5, **QUICK))
TAILED = limited(CostLimit("fine", limit=0.95, tail=0.9, **QUICK), CostLimit("nothing", limit=1.0))
"""Configurations of several tests, so that what is compiled for one serves the others."""


def play(game, config, updates=200, last=40):
    """The learner, and the means of its last updates' metrics."""
    learner, lines = init(game, config, jax.random.key(0), others=OTHERS), []
    for _ in range(updates):
        learner, metrics = update(game, config, learner)
        lines.append({name: float(x) for name, x in metrics.items()})
    return learner, {name: float(np.mean([line[name] for line in lines[-last:]])) for name in lines[0]}


def test_costs_without_a_limit_change_nothing():
    """To the bit, and no number about them is logged."""
    _, charged = play(TOLL, CONFIG, updates=2, last=1)
    _, free = play(games.game("bandit"), CONFIG, updates=2, last=1)
    assert charged == free


def test_what_pays_and_costs_is_done_as_often_as_the_limit_allows():
    """Half of the scenarios cost 4 if one takes the 1 that action 1 pays, the others nothing, and it is seen which.

    Without a limit one takes it always: a reward of 1, a cost of 2. With a limit of 0.4 the best is to take it where it
    is free, and in a fifth of the scenarios in which it costs 4: a reward of 0.5 + 0.5 x 0.2 = 0.6. There the
    multiplier makes up for the reward, 1 = lambda x 0.5 x 4.
    """
    _, plain = play(TOLL, limited(CostLimit("nothing", limit=1.0)), updates=60, last=20)
    assert plain["reward/driver"] > 0.95
    assert (plain["cost/driver/nothing"], plain["multiplier/driver/nothing"]) == (0, 0)
    learner, found = play(TOLL, AT_TIMES)
    assert found["cost/driver/fine"] == pytest.approx(0.4, abs=0.1)
    assert found["reward/driver"] == pytest.approx(0.6, abs=0.08)
    assert found["multiplier/driver/fine"] == pytest.approx(0.5, abs=0.15)
    chances = eqx.filter_jit(lambda actor, seen: jax.nn.softmax(actor(seen).logits, axis=0))
    free, fined = np.asarray(chances(learner.actors["driver"], np.float32([[1, -1], [0, 0], [0, 0]])))[1]
    assert free > 0.9
    assert 0.05 < fined < 0.5
    assert list(learner.critics) == ["driver", "driver fine"]
    assert found["driver fine/explained_variance"] > 0.1, "a scenario tells much of the cost, chance the rest"


def test_without_an_episode_s_end_nothing_changes():
    """Five steps of episodes of 100: the costs of such a rollout say nothing about whole episodes."""
    game = dataclasses.replace(TOLL, length=jnp.int32(100))
    learner, metrics = update(game, AT_TIMES, init(game, AT_TIMES, jax.random.key(0), others=OTHERS))
    assert float(metrics["episodes"]) == 0
    assert float(metrics["cost/driver/fine"]) == 0
    assert the_same(learner.multipliers, fresh_multipliers(AT_TIMES))


@pytest.mark.long
def test_a_limited_tail_asks_for_more_care_than_a_limited_mean():
    """The worst tenth of the costs (1 + a)^2 u are those above 0.9 (1 + a)^2, on average 0.95 (1 + a)^2; the mean is
    half of (1 + a)^2. So a limit of 0.95 allows a = 0 for the tail, a = 0.378 for the mean, and no limit a = 1 (less
    what noise, cut off at 1, takes away).
    """
    _, plain = play(HASTE, limited(CostLimit("nothing", limit=1.0)))
    assert plain["reward/driver"] > 0.7
    _, mean = play(HASTE, limited(CostLimit("fine", limit=0.95, **QUICK)))
    assert mean["reward/driver"] == pytest.approx(0.378, abs=0.08)
    assert mean["cost/driver/fine"] == pytest.approx(0.95, abs=0.08)
    _, tail = play(HASTE, TAILED)
    assert tail["reward/driver"] == pytest.approx(0.0, abs=0.12)
    assert tail["cost/driver/fine"] == pytest.approx(0.95, abs=0.08)
    assert tail["threshold/driver/fine"] == pytest.approx(0.9, abs=0.1)


@pytest.mark.parametrize("shards", [1, pytest.param(2, marks=pytest.mark.long)])
def test_resumed_training_equals_uninterrupted_training(shards, tmp_path):
    game, config = HASTE, dataclasses.replace(TAILED, shards=shards)
    learner = init(game, config, jax.random.key(0), others=OTHERS)
    for number in range(1, 4):
        learner, _ = update(game, config, learner)
        save(tmp_path, learner, updates=number)
    before = restore(tmp_path, init(game, config, jax.random.key(7), others=OTHERS), updates=2)
    assert float(before.multipliers["driver fine"].threshold) > 0
    resumed, _ = update(game, config, before)
    assert the_same(resumed, learner)


def test_shared_out_environments_count_the_same_costs():
    _, one = play(HASTE, TAILED, updates=3, last=1)
    _, two = play(HASTE, dataclasses.replace(TAILED, shards=2), updates=3, last=1)
    for name in one:
        assert two[name] == pytest.approx(one[name], rel=1e-3, abs=1e-4), name


@pytest.mark.long
def test_a_gated_role_with_several_agents_has_a_limit_of_each():
    """Two pedestrians, who are fined 1 for going where they decide; costs are counted for each of them."""

    class Fined(games.Game):
        def step(self, scenario, state, actions):
            after, outcome = super().step(scenario, state, actions)
            return after, dataclasses.replace(outcome, costs={"pedestrian": {"going": 1.0 * actions["pedestrian"]}})

    game = made(Fined)
    role = dataclasses.replace(ROLE, gated=True, limits=(CostLimit("going", limit=0.6, **QUICK),))
    config = games.with_roles(CONFIG, driver=dataclasses.replace(ROLE, fixed=0.0), pedestrian=role)
    learner, metrics = update(game, config, init(game, config, jax.random.key(0)))
    # half of the scenarios leave them nothing to decide, so they go; in the other half they do what chance says
    costs = [float(metrics["cost/pedestrian/going"])]
    assert costs[0] == pytest.approx(0.75, abs=0.05)
    for _ in range(200):
        learner, metrics = update(game, config, learner)
        costs.append(float(metrics["cost/pedestrian/going"]))
    assert max(costs) > 0.9, "without a multiplier they learn to go"
    assert np.mean(costs[100:]) == pytest.approx(0.6, abs=0.08)


@pytest.mark.long
def test_turns_share_the_multipliers():
    crowds = [dataclasses.replace(HASTE, people=people) for people in (2, 3)]
    config = limited(CostLimit("fine", limit=0.1, **QUICK))
    learner = init_in_turns(crowds, config, jax.random.key(0), others=OTHERS)
    values = []
    for number in range(3):
        learner, metrics = update_in_turns(crowds, config, learner, number)
        values.append(float(metrics["multiplier/driver/fine"]))
    assert 0 < values[0] < values[1] < values[2]
    assert float(learner.multipliers["driver fine"].value) == values[2]


def test_what_cannot_be_limited_is_refused():
    with pytest.raises(ValueError, match=r"limits: the driver has no cost 'noise'; there are: fine, nothing"):
        init(TOLL, limited(CostLimit("noise", limit=1.0)), jax.random.key(0), others=OTHERS)
    with pytest.raises(ValueError, match=r"limits: the driver has no cost 'fine'; there are: none"):
        init(games.game("bandit"), limited(LIMIT), jax.random.key(0), others=OTHERS)
    with pytest.raises(ValueError, match="limits must be of different costs"):
        dataclasses.replace(ROLE, limits=(LIMIT, LIMIT))
    with pytest.raises(ValueError, match="limits go with individual credit only"):
        dataclasses.replace(limited(LIMIT), credit="shared")
    for name, value in {"cost": "", "limit": 0.0, "worth": -1.0, "tail": 1.0, "integral": -0.1}.items():
        with pytest.raises(ValueError, match=f"^{name} must"):
            dataclasses.replace(LIMIT, **{name: value})


def test_a_limit_of_a_role_that_does_not_learn_is_no_limit():
    config = games.with_roles(CONFIG, pedestrian=dataclasses.replace(ROLE, fixed=1.0, limits=(LIMIT,)))
    assert config.limits == {}
    assert shard_of(config, hyperparameters(config)).config.limits == {}
