"""Makes the environment and the policies that a configuration names."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from pathlib import Path

import jax

from jaxwalk.interfaces import Policy, Roles
from jaxwalk.learning.config import GLOBAL, WHOLE_MINIBATCH, TrainConfig
from jaxwalk.maps import MapError, MapText
from jaxwalk.peers import several
from jaxwalk.recipes import Experiment, with_training
from jaxwalk.runs.kept_archives import with_archives
from jaxwalk.shards import everywhere, mesh_of
from jaxwalk.sim.cost import DRIVER_COSTS, PAID_ONCE
from jaxwalk.sim.environment import Street
from jaxwalk.sim.observation import OBSERVATIONS
from jaxwalk.sim.sim_config import SimConfig

LEAST_SHARE = 64
"""Smallest number of environments for each core: fewer don't keep it busy."""

COUNTS = "whose size is that of the crowd"
"""Why crowds can't have critics that see everybody."""


class WorldError(ValueError):
    """A configuration that can't be trained. The message names the field and its possible values, in one line."""


def make_street(
    experiment: Experiment, maps: Sequence[MapText] | None = None, archives: Sequence[str | Path] | None = None
) -> Street:
    """Return the environment of an experiment, on the maps and with the archives that it names or a run folder keeps.

    Raises:
        MapError: a map is wrong.
        ArchiveError, KeptArchiveError: scenarios to mix in can't be read, or aren't of this street.
        WorldError: what agents are paid for, are shown, or have a limit of, doesn't exist.
    """
    _check_sets(experiment)
    _check_limits(experiment)
    try:
        street = _street(experiment, experiment.maps if maps is None else maps)
    except MapError:
        raise
    except ValueError as error:
        raise WorldError(str(error)) from error
    mixed_in = experiment.archives if archives is None else archives
    return with_archives(street, experiment, mixed_in) if mixed_in else street  # importing archives takes a while


def crowded(street: Street, experiment: Experiment) -> tuple[Street, ...]:
    """Return the street with each number of people that updates take turns with; without ``crowds``, itself."""
    return tuple(map(street.with_people, experiment.crowds)) or (street,)


def on_devices(street: Street, experiment: Experiment) -> tuple[Street, ...]:
    """Return `crowded`, with tables on every device of the training, so that no update must copy them there.

    Raises ShardsError if there are fewer devices than shards.
    """
    return crowded(everywhere(street, mesh_of(experiment.train.shards)), experiment)


def _street(experiment: Experiment, maps: Sequence[str | MapText]) -> Street:
    """Return the street, which counts the costs that have limits."""
    return Street.create(
        maps,
        experiment.sim,
        jaywalk_multiplier=experiment.jaywalk_multiplier,
        driver_weights=experiment.driver_weights,
        pedestrian_weights=experiment.pedestrian_weights,
        driver_costs=[limit.cost for _, limit in experiment.train.limits.values()],
    )


def _check_sets(experiment: Experiment) -> None:
    """Raise WorldError for unknown observation sets, a gated driver, and crowds that critics can't see alike."""
    if experiment.train.roles["driver"].gated:
        raise WorldError("train.roles.driver.gated must be false: only pedestrians choose between 0 and 1")
    for role, sets in OBSERVATIONS.items():
        config = experiment.train.roles[role]
        _check_named(f"train.roles.{role}.observes", [config.observes], sets)
        _check_named(f"train.roles.{role}.critic_observes", config.critic_observes, [*sets, GLOBAL])
        if experiment.crowds and GLOBAL in config.critic_observes:
            raise WorldError(f"crowds: train.roles.{role}.critic_observes must not have {GLOBAL!r}, {COUNTS}")
    if experiment.crowds and experiment.train.credit == "shared":
        raise WorldError(f"crowds: train.credit must be individual, as the shared critic sees {GLOBAL!r}, {COUNTS}")


def _check_limits(experiment: Experiment) -> None:
    """Raise WorldError for limits of what the street doesn't count, and tails of costs that aren't paid once."""
    for role, limit in experiment.train.limits.values():
        _check_named(f"train.roles.{role}.limits", [limit.cost], DRIVER_COSTS if role == "driver" else ())
        if limit.tail and limit.cost not in PAID_ONCE:
            raise WorldError(f"train.roles.{role}.limits: tail must be 0 but for {', '.join(PAID_ONCE)}")


def _check_named(field: str, names: Iterable[str], known: Collection[str]) -> None:
    for name in names:
        if name not in known:
            raise WorldError(f"{field} must be one of {', '.join(known) or 'none'}, not {name!r}")


def whole_minibatches(experiment: Experiment) -> Experiment:
    """Return the experiment with gradients of whole minibatches on an accelerator, if its chunks are the default."""
    default = experiment.train.chunk_rows == TrainConfig.chunk_rows
    if jax.devices()[0].platform == "cpu" or not default:
        return experiment
    return with_training(experiment, chunk_rows=WHOLE_MINIBATCH)


def shared_out(experiment: Experiment) -> Experiment:
    """Return the experiment with its environments shared out among as many processor cores as divide them evenly.

    An accelerator wants all of them. Several processes have one shard for each device. Chunks: see `whole_minibatches`.
    """
    experiment, devices = whole_minibatches(experiment), jax.devices()
    if several():
        return with_training(experiment, shards=len(devices))
    count, most = experiment.train.environments, len(devices) if devices[0].platform == "cpu" else 1
    fitting = (n for n in range(most, 1, -1) if count % n == 0 and count >= n * LEAST_SHARE)
    return with_training(experiment, shards=next(fitting, 1))


def fixed_policies(experiment: Experiment) -> Roles[Policy | None]:
    """Return the policies of the roles that aren't learned."""
    roles = experiment.train.roles
    return {role: _rule(role, experiment.sim) if choice.fixed else None for role, choice in roles.items()}


def _rule(role: str, sim: SimConfig) -> Policy:
    """Return the policy of a role that isn't learned."""
    from jaxwalk.policies.drivers import Careless, RouteFollower  # takes a while: all rules come with it
    from jaxwalk.policies.pedestrians import AlwaysGo

    if role == "pedestrian":
        return AlwaysGo()
    return Careless(RouteFollower(wheelbase=sim.wheelbase, max_steering=sim.max_steering), fastest=sim.max_speed)
