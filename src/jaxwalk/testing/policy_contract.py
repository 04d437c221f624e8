"""What a policy must do, so that training, evaluation, adapters and export can let it act."""

from __future__ import annotations

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Key

from jaxwalk.interfaces import Discrete, Environment, Moment, Policy, View, is_shared
from jaxwalk.rollout import draw_batch
from jaxwalk.testing.environment_contract import random_actions
from jaxwalk.testing.requirement import ContractError, episode, finite, form, require, same

BATCH = 4
"""Number of episodes that are checked together."""
ROUNDING = 1e-5
"""Tolerance between an episode played alone and in a batch, which may round differently."""

# What is played is always compiled, and a check is several times as quick so. What acts again is compiled on its own:
# so chance from elsewhere than the keys comes out.
_draw = eqx.filter_jit(draw_batch)
_reset = eqx.filter_jit(lambda environment, scenario: environment.reset(scenario))
_observe = eqx.filter_jit(lambda environment, scenario, state, view: environment.observe(scenario, state, view))
_step = eqx.filter_jit(lambda environment, *now: environment.step(*now))
_act, _act_again = (eqx.filter_jit(lambda policy, *now: policy.act(*now)) for _ in range(2))


def check_driver(policy: Policy, environment: Environment, *, steps: int = 8, seed: int = 0) -> None:
    """Check a policy that plays ``driver``: see `check_policy`."""
    check_policy(policy, environment, "driver", steps=steps, seed=seed)


def check_pedestrians(policy: Policy, environment: Environment, *, steps: int = 8, seed: int = 0) -> None:
    """Check a policy that plays ``pedestrian``: see `check_policy`."""
    check_policy(policy, environment, "pedestrian", steps=steps, seed=seed)


def check_policy(policy: Policy, environment: Environment, role: str, *, steps: int = 8, seed: int = 0) -> None:
    """Let a policy play a role beside random others, and check everything that others rely on.

    Args:
        policy: what to check.
        environment: where it plays.
        role: the role it plays.
        steps: how many steps to play.
        seed: of scenarios, actions and keys.

    Raises:
        ContractError: something doesn't hold; the message says what.
    """
    spec = environment.roles[role]
    _check_view(policy.view)
    root = jax.random.key(seed)
    scenario = _draw(environment, jax.random.split(root, BATCH))
    state, memory = _reset(environment, scenario), policy.init(spec.agents, (BATCH,))
    require(same(memory, policy.init(spec.agents, (BATCH,))), "init: it must always give the same memory")
    for number in range(steps):
        own = jax.random.fold_in(root, number)
        seen = _observe(environment, scenario, state, policy.view)
        action, after = _check_act(policy, jax.random.split(own, BATCH), memory, seen)
        _check_action(action, environment, role)
        message = "act: the memory must keep its structure, shapes and types, for a scan over time"
        require(form(after) == form(memory), message)
        others = random_actions(environment.roles, own, BATCH)
        state, _ = _step(environment, scenario, state, others | {role: action})
        memory = after


def _check_view(view: View) -> None:
    require(isinstance(view.name, str) and view.name, "view: it must have a name, for results")
    require(callable(view), f"view: {view.name} must be a function of a {Moment.__name__}")
    try:
        hash(view)
    except TypeError as error:
        raise ContractError(f"view: {view.name} must be hashable: make it a frozen dataclass ({error})") from error


def _check_act(policy: Policy, keys: Key[Array, "episode"], memory: Any, seen: Any) -> tuple[Array, Any]:
    """Check one call of ``act``; return its result."""
    action, after = _act(policy, keys, memory, seen)
    again = _act_again(policy, keys, memory, seen)
    require(same((action, after), again), "act: equal keys, memories and views must give equal actions")
    own = [x for x in jax.tree.leaves((memory, seen), is_leaf=is_shared) if not is_shared(x)]
    batched = all(np.ndim(x) and np.shape(x)[-1] == BATCH for x in own)
    require(batched, "init, view: every array must end in the batch axis")
    one, _ = _act(policy, keys[-1:], episode(memory, BATCH - 1), episode(seen, BATCH - 1))
    message = "act: an episode's action must be the same alone as in a batch; it may not look at other episodes"
    require(same(one, action[..., -1:], tolerance=ROUNDING), message)
    return action, after


def _check_action(action: Array, environment: Environment, role: str) -> None:
    spec = environment.roles[role]
    choice = isinstance(spec.action, Discrete)
    wanted = (*spec.agents, BATCH) if isinstance(spec.action, Discrete) else (spec.action.size, *spec.agents, BATCH)
    shape = f"act: the {role}'s action has shape {action.shape}; it must be {wanted}: {spec.action} each"
    require(action.shape == wanted, shape)
    require(finite(action), f"act: the {role}'s action has a number that isn't finite")
    kind = jnp.issubdtype(action.dtype, jnp.integer if choice else jnp.floating)
    require(kind, f"act: the {role}'s action is {action.dtype}; it must be {'integers' if choice else 'floats'}")
    inside = f"act: the {role}'s action must be {spec.action}, but some are in [{action.min():g}, {action.max():g}]"
    require(spec.contains(action).all(), inside)
