"""What an environment must do, so that learner, evaluation and adapters can play it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Key

from jaxwalk.interfaces import Discrete, Environment, Outcome, Roles, RoleSpec
from jaxwalk.rollout import draw_batch
from jaxwalk.testing.requirement import ContractError, episode, finite, form, require, same, weak

BATCH = 4
"""Number of episodes that are checked together."""
ROUNDING = 1e-5
"""Tolerance between an episode played alone and in a batch, which may round differently."""

Seen = tuple[list[Array], Array]
Look = Callable[[Any, Any], Seen]
StepOnce = Callable[..., tuple[Any, Outcome]]


def check_environment(
    environment: Environment, views: Mapping[str, Sequence[str]], *, steps: int = 8, seed: int = 0
) -> None:
    """Play an environment with random actions and check everything that others rely on.

    Args:
        environment: what to check.
        views: names of flat views to check, by role.
        steps: how many steps to play.
        seed: of scenarios and actions.

    Raises:
        ContractError: something doesn't hold; the message says what.
    """
    roles = environment.roles
    require(roles, "roles: an environment has at least one role")
    require(list(roles) == list(environment.roles), "roles: they must always come in the same order")
    for role, spec in roles.items():
        require(isinstance(spec, RoleSpec), f"roles: {role} must be a RoleSpec, not {type(spec).__name__}")
    draw_key, action_key = jax.random.split(jax.random.key(seed))
    keys = jax.random.split(draw_key, BATCH)
    scenario = _compiled(draw_batch)(environment, keys)
    require(same(scenario, _compiled(draw_batch)(environment, keys)), "draw: equal keys must give equal scenarios")
    _check_batch("draw", scenario)
    state = _compiled(environment.reset)(scenario)
    require(same(state, _compiled(environment.reset)(scenario)), "reset: it must be deterministic")
    _check_batch("reset", state)
    _check_types(state)
    _check_unknown_view(environment)
    look, sees_all = _compiled(_looks(environment, views)), environment.unhidden(scenario, state) is state
    unhidden = _compiled(environment.unhidden)
    steps_twice = _compiled(environment.step), _compiled(environment.step)
    for number in range(steps):
        _check_seen(environment, views, look(scenario, state))
        if not sees_all:
            _check_seen(environment, views, look(scenario, unhidden(scenario, state)), of="unhidden, ")
        actions = random_actions(roles, jax.random.fold_in(action_key, number), BATCH)
        state = _check_step(environment, steps_twice, scenario, state, actions)


def _compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the function, compiled anew by each call of this: so chance from elsewhere than its keys comes out."""
    return eqx.filter_jit(lambda *arguments: function(*arguments))


def random_actions(roles: Roles[RoleSpec], key: Key[Array, ""], batch: int) -> Roles[Array]:
    """Return uniformly random actions of all agents."""
    found = {}
    for place, (role, spec) in enumerate(roles.items()):
        own, shape = jax.random.fold_in(key, place), (*spec.agents, batch)
        if isinstance(spec.action, Discrete):
            found[role] = jax.random.randint(own, shape, 0, spec.action.n)
        else:
            found[role] = jax.random.uniform(own, (spec.action.size, *shape), minval=-1, maxval=1)
    return found


def _check_batch(where: str, tree: Any) -> None:
    """Raise unless every array ends in the batch axis."""
    for path, x in jax.tree_util.tree_leaves_with_path(eqx.filter(tree, eqx.is_array)):
        name = jax.tree_util.keystr(path)
        require(x.shape[-1:] == (BATCH,), f"{where}: {name} has shape {x.shape}; arrays must end in the batch axis")


def _check_types(state: Any) -> None:
    """Raise if an array has a weak type."""
    rule = "give it one, such as jnp.full(shape, 2.0, jnp.float32), or what goes on from it is compiled twice"
    names = weak(state)
    require(not names, f"reset: {', '.join(names) or 'the state'} has no type of its own; {rule}")


def _check_unknown_view(environment: Environment) -> None:
    role = next(iter(environment.roles))
    try:
        environment.view(role, "no view has this name")
    except ValueError:
        return
    raise ContractError("view: it must raise ValueError for a name that there isn't")


def _looks(environment: Environment, views: Mapping[str, Sequence[str]]) -> Look:
    """Return the function that gives the views one after the other, and the global state."""
    made = [environment.view(role, name) for role, name in _names(views)]
    for view, (role, name) in zip(made, _names(views), strict=True):
        require(view == environment.view(role, name), f"view: {role} {name} must equal itself when made again")

    def look(scenario: Any, state: Any) -> Seen:
        return [environment.observe(scenario, state, view) for view in made], environment.global_state(scenario, state)

    return look


def _names(views: Mapping[str, Sequence[str]]) -> list[tuple[str, str]]:
    return [(role, name) for role, names in views.items() for name in names]


def _check_seen(environment: Environment, views: Mapping[str, Sequence[str]], everything: Seen, of: str = "") -> None:
    found, whole = everything
    for seen, (role, name) in zip(found, _names(views), strict=True):
        wanted = (*environment.roles[role].agents, BATCH)
        shape = f"(feature, {', '.join(map(str, wanted))})"
        require(seen.shape[1:] == wanted, f"{of}observe: {role} {name} has shape {seen.shape}; it must be {shape}")
        require(finite(seen), f"{of}observe: {role} {name} has a number that isn't finite")
    require(whole.shape[1:] == (BATCH,), f"global_state: it has shape {whole.shape}; it must be (feature, {BATCH})")
    require(finite(whole), "global_state: it has a number that isn't finite")


def _check_step(
    environment: Environment, steps: tuple[StepOnce, StepOnce], scenario: Any, state: Any, actions: Roles[Array]
) -> Any:
    """Check one step, given twice; return the state after it."""
    step, step_again = steps
    after, outcome = step(scenario, state, actions)
    again, outcome_again = step_again(scenario, state, actions)
    require(
        same((after, outcome), (again, outcome_again)), "step: it must be deterministic; all chance is in the scenario"
    )
    require(
        form(after) == form(state), "step: it must keep the state's structure, shapes and types, for a scan over time"
    )
    _check_outcome(environment, outcome)
    one = (episode(x, BATCH - 1) for x in (scenario, state, actions))
    alone, _ = step(*one)
    message = "step: an episode must come out the same alone as in a batch; it may not look at other episodes"
    require(same(alone, episode(after, BATCH - 1), tolerance=ROUNDING), message)
    return after


def _check_outcome(environment: Environment, outcome: Outcome) -> None:
    roles = environment.roles
    require(outcome.ended.shape == (BATCH,), f"ended: it has shape {outcome.ended.shape}; it must be ({BATCH},)")
    for part in ("rewards", "terminated", "truncated"):
        found = getattr(outcome, part)
        require(set(found) == set(roles), f"{part}: it must have the roles {', '.join(roles)}, not {', '.join(found)}")
    require(set(outcome.costs) <= set(roles), f"costs: it must have roles of {', '.join(roles)} only")
    for role, spec in roles.items():
        shape = (*spec.agents, BATCH)
        for name, cost in outcome.costs.get(role, {}).items():
            require(cost.shape == shape, f"costs: {role} {name} has shape {cost.shape}; it must be {shape}")
            require(finite(cost) and (cost >= 0).all(), f"costs: {role} {name} must be finite numbers of 0 or more")
        for name, term in outcome.rewards[role].items():
            require(term.shape == shape, f"rewards: {role} {name} has shape {term.shape}; it must be {shape}")
            require(finite(term), f"rewards: {role} {name} has a number that isn't finite")
        over = outcome.terminated[role] | outcome.truncated[role]
        require(over.shape == shape, f"terminated, truncated: {role}'s must have shape {shape}, not {over.shape}")
        require(over.dtype == jnp.bool_, f"terminated, truncated: {role}'s must be true or false, not {over.dtype}")
        both = outcome.terminated[role] & outcome.truncated[role]
        require(not both.any(), f"terminated, truncated: an agent of {role} is both at once")
        message = f"ended: an episode ends for everybody at once, but not for {role}"
        require(np.array_equal(over, np.broadcast_to(outcome.ended, shape)), message)
