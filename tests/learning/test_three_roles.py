"""A third role is one more entry of every mapping: a game with three roles trains through the real learner."""

from __future__ import annotations

from dataclasses import dataclass, replace

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.acting import act, cast_of, fresh_memory, role_key, step_key
from jaxwalk.interfaces import Box, Discrete, Moment, Outcome, RoleSpec
from jaxwalk.learning.config import RoleConfig, TrainConfig
from jaxwalk.learning.mappo import init, update

ROLE = RoleConfig(observes="all", critic_observes=("all",), actor_hidden=(16,), critic_hidden=(16,), entropy=0.003)
CONFIG = TrainConfig(
    {"tram": ROLE, "cyclist": ROLE, "driver": ROLE}, environments=32, steps=16, minibatches=4, updates=40,
    learning_rate=5e-3, discount=0.9, shared_critic_hidden=(16,), chunk_rows=64,
)  # fmt: skip


@dataclass(frozen=True)
class All:
    agents: tuple[int, ...]
    name: str = "all"

    def __call__(self, moment):
        shape = moment.scenario.shape
        seen = moment.scenario.reshape(1, *(1,) * len(self.agents), *shape)
        return jnp.broadcast_to(seen, (1, *self.agents, *shape))


class Crossing(eqx.Module):
    """A tram, three cyclists and a car: each is paid for doing what the scenario, -1 or 1, asks of its role."""

    @property
    def roles(self):
        return {
            "tram": RoleSpec((), Discrete(2)),
            "cyclist": RoleSpec((3,), Discrete(3)),
            "driver": RoleSpec((), Box(1)),
        }

    def draw(self, key):
        return jnp.where(jax.random.bernoulli(key), 1.0, -1.0)

    def reset(self, scenario):
        return jnp.zeros(scenario.shape, jnp.int32)

    def view(self, role, name):
        return All(self.roles[role].agents)

    def observe(self, scenario, state, view):
        return view(Moment(None, scenario, state))

    def unhidden(self, scenario, state):
        return state

    def global_state(self, scenario, state):
        return scenario[None]

    def step(self, scenario, state, actions):
        pay = {
            "tram": 1.0 * (actions["tram"] == (scenario > 0)),
            "cyclist": 1.0 * (actions["cyclist"] == jnp.where(scenario > 0, 2, 0)),
            "driver": 1.0 - (actions["driver"][0] - 0.5 * scenario) ** 2,
        }
        over = state + 1 >= 2
        none = {role: jnp.zeros(x.shape, bool) for role, x in pay.items()}
        ends = {role: jnp.broadcast_to(over, x.shape) for role, x in pay.items()}
        return state + 1, Outcome({role: {"pay": x} for role, x in pay.items()}, ends, none, over, {"goal": over})


@pytest.mark.parametrize("credit", ["individual", pytest.param("shared", marks=pytest.mark.long)])
def test_three_roles_learn(credit):
    game, config = Crossing(), replace(CONFIG, credit=credit)
    learner = init(game, config, jax.random.key(0))
    for _ in range(40):
        learner, metrics = update(game, config, learner)
    assert set(learner.actors) == set(CONFIG.roles)
    for role in CONFIG.roles:
        assert float(metrics[f"reward/{role}"]) > 0.9, role


def test_other_roles_than_the_environments_are_refused():
    two = TrainConfig({"driver": ROLE, "tram": ROLE}, environments=8, steps=8)
    with pytest.raises(ValueError, match="roles must be the environment's, tram, cyclist, driver, not driver, tram"):
        init(Crossing(), two, jax.random.key(0))


class Dice(eqx.Module):
    """Shows its key, and remembers how often it acted."""

    size: int = eqx.field(static=True)
    view: All = eqx.field(static=True)

    def init(self, agents, batch):
        return jnp.zeros((*agents, *batch), jnp.int32)

    def act(self, key, memory, seen):
        bits = jax.vmap(lambda k: jax.random.bits(k, (self.size,)), out_axes=-1)(key)
        return bits, memory + 1


def test_every_role_has_its_own_key_in_the_order_of_the_environments_roles():
    game, keys = Crossing(), jax.random.split(jax.random.key(3), 5)
    policies = {role: Dice(4, All(spec.agents)) for role, spec in game.roles.items()}
    cast = cast_of(policies)

    @eqx.filter_jit
    def everybody_acts(keys):
        """What all do together, each with its key, and keys by the rule of evaluations since 0.1 beside today's."""
        memory, key, scenario = fresh_memory(game, cast, (5,)), step_key(keys, jnp.arange(5)), jnp.ones(5)
        together = act(game, cast, key, scenario, game.reset(scenario), memory)
        own = [role_key(key, place) for place in range(3)]
        alone = [policies[role].act(k, memory[role][0], None)[0] for role, k in zip(game.roles, own, strict=True)]
        split = jax.vmap(lambda k: jax.random.split(k, 3), out_axes=1)(key)
        return together, alone, (jax.random.key_data(split[1]), jax.random.key_data(own[1]))

    together, alone, (split, own) = everybody_acts(keys)
    drawn = [np.asarray(together.actions[role]) for role in game.roles]
    assert len({x.tobytes() for x in drawn}) == 3
    for role, expected in zip(game.roles, alone, strict=True):
        np.testing.assert_array_equal(together.actions[role], expected)
        assert (np.asarray(together.memory[role][0]) == 1).all()
    np.testing.assert_array_equal(split, own)  # the step's key, split among the roles
