"""Finds drivers and populations by name, and the street to evaluate them on.

A name is a rule, a shipped policy, a run folder, a policy file, a driver that isn't written in JAX, a mixture, or a
driver behind a shield.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import equinox as eqx
import jax

from jaxwalk.evaluation import SAMPLES, with_mode
from jaxwalk.interfaces import Box, Discrete, Policy
from jaxwalk.learning.actor import DISCRETE, GATED, Actor
from jaxwalk.maps import map_labels
from jaxwalk.policies import DRIVERS, POPULATIONS, load_policy, read_metadata
from jaxwalk.policies.groups import Groups
from jaxwalk.policies.host import SECONDS, is_host_driver, load_host_driver
from jaxwalk.policies.mixture import Mixture
from jaxwalk.policies.mixture_names import mixture_of
from jaxwalk.policies.shield_names import unshielded
from jaxwalk.policies.shielding import shielded
from jaxwalk.policies.world_numbers import with_limits
from jaxwalk.runs.binding import check_intact
from jaxwalk.runs.contestant_names import ContestantError, policy_file, run_folders
from jaxwalk.runs.folder import Run
from jaxwalk.runs.kept_maps import to_stderr
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import SimConfig, rules_of
from jaxwalk.sim.suites import SUITES, Where

ANYWHERE = Where()
"""No place is asked for: the run folders decide."""
MADE = {"driver": DRIVERS, "pedestrian": POPULATIONS}
"""Rule-based policies of each role, by name."""


def world_of(names: Sequence[str], where: Where = ANYWHERE, tell: Callable[[str], None] = to_stderr) -> Street:
    """Return the street to evaluate on: the given maps and rules, else those that the named run folders keep.

    A suite decides them all, whatever the folders have. ``tell`` is called with a warning for each folder that keeps
    no maps. Raise ContestantError if the folders differ in what ``where`` leaves out, and ValueError for a world or a
    number of people that doesn't exist.
    """
    maps, world = where.maps, where.world
    runs = [Run.open(name) for name in run_folders(names)]
    for run in runs:
        check_intact(run)
    if any(where is suite for suite in SUITES.values()):
        return Street.create(where.maps, _crowded(where, rules_of(where.world, where.maps)))
    trained = [] if maps else list(dict.fromkeys(run.maps(tell) for run in runs))
    if len(trained) > 1:
        labels = map_labels([x for each in trained for x in each])
        raise ContestantError(
            f"the run folders were trained on different maps ({', '.join(labels)}); choose some with --map"
        )
    trained_in = [run.experiment.sim for run in runs]
    worlds = list(dict.fromkeys(_crowded(where, rules_of(world, (), one) if world else one) for one in trained_in))
    if len(worlds) > 1:
        alike = len({rules_of("paper", (), one) for one in worlds}) == 1
        hint = "; choose one with --world" if alike else ""
        raise ContestantError(f"the run folders were trained in worlds of different rules (sim in config.json){hint}")
    chosen = tuple(maps) or (trained[0] if trained else ("paper",))
    return Street.create(chosen, worlds[0] if worlds else _crowded(where, rules_of(world, maps or ("paper",))))


def _crowded(where: Where, rules: SimConfig) -> SimConfig:
    """Return rules with the number of people that was named, if any."""
    return rules if where.people is None else replace(rules, pedestrians=where.people)


def contestant(
    street: Street, role: str, name: str, *, sample: bool | None = None, trust: bool = False, seconds: float = SECONDS
) -> Policy:
    """Return the policy of that name for a role. Where people walk in groups, a population's leaders decide (`Groups`).

    Args:
        street: the world it is to act in.
        role: ``driver`` or ``pedestrian``.
        name: of a rule, a shipped policy, a run folder, a policy file or, for a driver, what `load_host_driver` takes;
            for pedestrians also a mixture (`mixture_of`), for a driver also one behind a shield (`unshielded`).
        sample: it draws its actions at random (default: as `SAMPLES` says).
        trust: also load what can run code that is hidden in a file.
        seconds: the limit of a driver that is not JAX for one step.
    """
    policy = named_policy(street, role, name, sample=sample, trust=trust, seconds=seconds)
    return Groups(policy) if role == "pedestrian" and street.world.rules.grouped else policy


def named_policy(
    street: Street, role: str, name: str, *, sample: bool | None = None, trust: bool = False, seconds: float = SECONDS
) -> Policy:
    """Return the policy of that name itself, as `contestant`: people decide for themselves, also in groups."""
    bare, shield = unshielded(role, name)
    if shield is not None:
        driver = named_policy(street, role, bare, sample=sample, trust=trust, seconds=seconds)
        return shielded(driver, shield)
    mixed = mixture_of(role, name)
    if mixed:
        kinds = (named_policy(street, role, kind, sample=sample) for kind in mixed)
        return Mixture(tuple(kinds), tuple(mixed.values()))
    rules: dict[str, Any] = MADE[role]
    if name in rules:
        return with_limits(rules[name](), street.config)
    if role == "driver" and is_host_driver(name):
        return load_host_driver(name, trust=trust, seconds=seconds)
    file = policy_file(role, name)
    observes = read_metadata(file)["roles"].get(role, {}).get("observes", "paper")
    policy = load_policy(file, role, expect_size=_observation_size(street, role, observes, file))
    _check_action(policy.actor, street.roles[role].action, f"{file}: the {role}")
    return with_mode(policy, sample=SAMPLES[role] if sample is None else sample)


def _check_action(actor: Actor, action: Box | Discrete, who: str) -> None:
    """Raise ContestantError unless the network's outputs are an action of that kind."""
    discrete, outputs = isinstance(action, Discrete), action.n if isinstance(action, Discrete) else action.size
    if (actor.kind in (DISCRETE, GATED)) != discrete or actor.network.sizes[-1] != outputs:
        wanted = f"chooses among {outputs}" if discrete else f"gives {outputs} numbers"
        raise ContestantError(
            f"{who} {wanted}, but the network has {actor.network.sizes[-1]} {actor.kind} outputs; train anew"
        )


def _observation_size(street: Street, role: str, observes: str, file: Path) -> int:
    """Return the number of features of an observation set."""

    def look() -> jax.Array:
        scenario = street.draw(jax.random.key(0))
        return street.observe(scenario, street.reset(scenario), street.view(role, observes))

    try:
        return eqx.filter_eval_shape(look).shape[0]
    except (KeyError, ValueError) as error:
        raise ContestantError(
            f"{file}: the {role} reads the observation set {observes!r}, which this jaxwalk has not; train anew"
        ) from error
