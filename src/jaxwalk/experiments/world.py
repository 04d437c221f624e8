"""From a configuration to the environment and policies that it names."""

from __future__ import annotations

from jaxwalk.experiments.recipes import Experiment
from jaxwalk.interfaces import ByRole, Policy
from jaxwalk.policies.drivers import Careless, RouteFollower
from jaxwalk.policies.pedestrians import AlwaysGo
from jaxwalk.sim.environment import Street


def make_street(experiment: Experiment) -> Street:
    """The environment of an experiment."""
    return Street.create(
        experiment.maps,
        experiment.sim,
        jaywalk_multiplier=experiment.jaywalk_multiplier,
        driver_weights=experiment.driver_weights,
        pedestrian_weights=experiment.pedestrian_weights,
    )


def fixed_policies(experiment: Experiment) -> ByRole[Policy | None]:
    """Who plays a role where its learner doesn't."""
    train, sim = experiment.train, experiment.sim
    follower = RouteFollower(wheelbase=sim.wheelbase, max_steering=sim.max_steering)
    return ByRole(
        driver=Careless(follower) if train.driver.fixed else None,
        pedestrian=AlwaysGo() if train.pedestrian.fixed else None,
    )
