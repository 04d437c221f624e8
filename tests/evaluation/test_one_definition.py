"""Training logs the rates that `evaluate` finds: one definition of goal, collision and timeout."""

from dataclasses import replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.acting import SCENARIO_KEYS
from jaxwalk.evaluation.playing import play
from jaxwalk.learning import mappo
from jaxwalk.metrics.outcomes import measure_outcomes
from jaxwalk.policies import AlwaysGo, load_policy
from jaxwalk.policies.shipped import shipped_policy
from jaxwalk.recipes import RECIPES, single_agent, with_training
from jaxwalk.rollout import TRAINING, draw_batch, seed_key
from jaxwalk.runs.street import fixed_policies, make_street

ENVIRONMENTS, STEPS = 64, 512
"""In 512 steps every environment ends an episode at least: its horizon is 500."""


@pytest.fixture(scope="module")
def trained():
    """The street, the driver, and an update in which that driver, without noise, plays among people who always go."""
    fast = RECIPES["fast"]
    driver = load_policy(shipped_policy("driver", "co-trained"), "driver")
    roles = {role: replace(config, epochs=1) for role, config in fast.train.roles.items()}
    roles["driver"] = replace(roles["driver"], observes=driver.actor.observes)
    experiment = single_agent(with_training(fast, steps=STEPS, minibatches=1, roles=roles))
    experiment = with_training(experiment, environments=ENVIRONMENTS)
    street, others = make_street(experiment), fixed_policies(experiment)
    learner = mappo.init(street, experiment.train, seed_key(0, TRAINING), others=others)
    quiet = eqx.tree_at(lambda actor: actor.log_std, driver.actor, jnp.full_like(driver.actor.log_std, -100.0))
    learner = eqx.tree_at(lambda x: x.actors["driver"], learner, quiet)
    after, metrics = mappo.update(street, experiment.train, learner)
    return street, driver, after.stream, {name: float(x) for name, x in metrics.items()}


def _ended(stream):
    """The keys of all scenarios that came to their end in the rollout."""
    counts = np.asarray(stream.episode) + np.asarray(stream.ended)
    of = np.repeat(np.arange(len(counts)), counts)
    number = np.concatenate([np.arange(n) for n in counts])
    keys = jax.vmap(lambda key: jax.random.fold_in(key, SCENARIO_KEYS))(stream.key[of])
    return jax.vmap(jax.random.fold_in)(keys, number)


@pytest.mark.long
def test_the_rates_of_training_are_those_of_evaluation(trained):
    street, driver, stream, metrics = trained
    keys = _ended(stream)
    assert len(keys) == metrics["episodes"] > ENVIRONMENTS
    trajectory = play(street, {"driver": driver, "pedestrian": AlwaysGo()}, draw_batch(street, keys), keys)
    found = measure_outcomes(trajectory, moving_speed=0.5)
    counts = {"goal": found.goal.sum(), "collision": found.collision.sum()}
    counts["timeout"] = (~found.goal & ~found.collision).sum()
    logged = {name: round(metrics[f"{name}_rate"] * metrics["episodes"]) for name in counts}
    assert logged == {name: int(count) for name, count in counts.items()}
    assert logged["goal"] > 0
    assert logged["collision"] > 0
