"""What drivers do in crash tests: avoid a contact, or touch somebody at a speed; and whether they brake for nothing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import shapely

from jaxwalk.evaluation.playing import play
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.metrics.footprint import in_car_frame
from jaxwalk.scenarios import Scripted
from jaxwalk.scenarios.staging import KMH, Case
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.sim.trajectory import Trajectory, part_of

AT_ONCE = 128
"""Tests that are played at once."""
STANDS = 0.1
"""A car slower than this stands, and a test in which everybody has set out is over [m/s]."""
SET_OUT = 1e-3
"""Who is farther than this from where they began has set out [m]."""
UNSLOWED = 1.0
"""An impact less than this below the speed of the test is one of a car that didn't slow down [km/h]."""
OUT_OF_LANE = 0.85
"""A car farther than this beside its route leaves a lane of 3.5 m with its side [m]."""
ON_FRONT = 0.05
"""A body touches the front if its centre is at most this far behind it [m]."""

CrashResult = Literal["avoided", "slowed", "unslowed", "not met", "kept", "braked"]
"""What a driver did.

Where it should brake, it ``avoided`` a contact, or was ``slowed`` or ``unslowed`` at the impact; ``not met``: nobody
set out, because it never came near. Where it should not, it ``kept`` its speed, or ``braked`` too much.
"""


@dataclass(frozen=True)
class CrashOutcome:
    """What a driver did in one run of a test. Speeds are in km/h, as protocols have them."""

    scenario: int
    """The number of the run."""
    test: str
    variant: str | None
    layer: str
    no_brake: bool
    """Whether it is a test without need to brake."""
    speed: float
    """The car's speed at the start [km/h]."""
    result: CrashResult
    impact: float | None
    """The car's speed at the contact [km/h]; None without one."""
    hit_point: float | None
    """Where the front touched the body, in per cent of its width from the right edge; None for other parts."""
    slowest: float
    """The car's lowest speed in the test [km/h]."""
    hardest: float
    """The hardest braking in the test: the largest loss of speed in a step, over its duration [m/s2]."""
    aside: float
    """How far the car was beside its route, at most [m]."""
    ends: float
    """When the test ended: with a contact, or when the car stood, or was at its goal [s]."""
    passed: bool | None
    """Whether the driver did what the test asks for; None where it asks for nothing."""
    touched_later: bool
    """Whether the car touched somebody after it had stood, when the test was over."""

    @property
    def test_name(self) -> str:
        """Return the name of the test."""
        return self.test

    @property
    def asks(self) -> bool:
        """Return whether the test asks for anything."""
        return self.passed is not None

    @property
    def swerves(self) -> bool:
        """Return whether the car left its lane: it may have avoided a contact by that."""
        return self.aside > OUT_OF_LANE

    @property
    def fails(self) -> bool:
        """Return whether the driver touched somebody, was never met, or braked for nothing."""
        return self.result not in ("avoided", "kept")


def crash_test(policies: Roles[Policy], source: Scripted) -> tuple[CrashOutcome, ...]:
    """Play all runs of a source, and return what the driver did in each. Errors are those of `play_tests`."""
    return tuple(outcome for part in play_tests(policies, source) for outcome in crash_outcomes(source, part))


def play_tests(policies: Roles[Policy], source: Scripted) -> Iterator[Trajectory]:
    """Yield all runs of a source, some at a time.

    Args:
        policies: the policy of each role; people should always go.
        source: the runs.

    Raises:
        DriverError: a driver that is not JAX failed.
        ActionError: an action of another policy isn't in its space.
    """
    count = len(source)
    batch = -(-count // -(-count // AT_ONCE))  # parts of one size, which one program plays
    for first in range(0, count, batch):
        numbers = (first + np.arange(batch)) % count
        scenarios, keys = source.take(numbers)
        trajectory = play(source.street, policies, scenarios, keys, numbers=numbers)
        yield part_of(trajectory, frames=len(trajectory.car_x), episodes=slice(min(batch, count - first)))


def crash_outcomes(source: Scripted, trajectory: Trajectory) -> list[CrashOutcome]:
    """Return what the driver did in each episode of a trajectory of a source."""
    cases, config = [source.cases[number] for number in trajectory.scenario], source.street.config
    outcomes = [_outcome(case, trajectory, episode, config) for episode, case in enumerate(cases)]
    return [replace(one, aside=_aside(source, trajectory, episode, one)) for episode, one in enumerate(outcomes)]


def _outcome(case: Case, trajectory: Trajectory, episode: int, config: SimConfig) -> CrashOutcome:
    last, people = int(trajectory.length[episode]), case.test.people
    x, y = (column[: last + 1, episode, : len(people)] for column in (trajectory.ped_x, trajectory.ped_y))
    away = np.hypot(x - x[:1], y - y[:1]) > SET_OUT
    begun = (away | ~np.array([person.speed > 0 for person in people], bool)).all(axis=1)
    speed = trajectory.car_speed[: last + 1, episode]
    over = begun & (speed < STANDS) & (not case.no_brake)
    end = int(over.argmax()) if over.any() else last
    touches = bool(trajectory.collision[episode])
    contact = touches and end == last and speed[last] >= STANDS
    impact = KMH * float(speed[last]) if contact else None
    losses = -np.diff(speed[: end + 1 - contact]) / trajectory.dt  # the step of a contact is shorter
    of_car = {"slowest": KMH * float(speed[: end + 1].min()), "hardest": max(0.0, float(losses.max(initial=0.0)))}
    result = _result(case, impact, bool(begun.any()), of_car, bool(trajectory.goal[episode]))
    return CrashOutcome(
        scenario=int(trajectory.scenario[episode]),
        test=case.test.name,
        variant=case.variant,
        layer=case.layer,
        no_brake=case.no_brake,
        speed=case.speed,
        result=result,
        impact=impact,
        hit_point=_hit_point(trajectory, episode, config) if contact else None,
        aside=0.0,
        ends=round(end * trajectory.dt, 6),
        passed=_passed(case, result, impact),
        touched_later=touches and not contact,
        **of_car,
    )


def _aside(source: Scripted, trajectory: Trajectory, episode: int, outcome: CrashOutcome) -> float:
    """Return how far the car was beside its route until the end of a test, at most [m]."""
    route = source.route(outcome.scenario)
    frames = slice(round(outcome.ends / trajectory.dt) + 1)
    places = shapely.points(trajectory.car_x[frames, episode], trajectory.car_y[frames, episode])
    return float(shapely.distance(route, places).max())


def _result(case: Case, impact: float | None, met: bool, of_car: dict[str, float], arrived: bool) -> CrashResult:
    rule = case.test.passes
    if rule.deceleration is not None and impact is None:
        calm = of_car["hardest"] <= rule.deceleration and of_car["slowest"] >= (rule.keeps or 0) * case.speed
        return "kept" if calm and arrived else "braked"
    if impact is not None:
        return "unslowed" if impact > case.speed - UNSLOWED else "slowed"
    return "avoided" if met else "not met"


def _passed(case: Case, result: CrashResult, impact: float | None) -> bool | None:
    """Return whether the driver did what a test asks for; None where it asks for nothing."""
    if case.no_brake:
        return result == "kept"
    most = case.test.passes.most_impact(case.speed)
    if most is None:
        return None
    return result == "avoided" or (impact is not None and most > 0 and impact <= most)


def _hit_point(trajectory: Trajectory, episode: int, config: SimConfig) -> float | None:
    """Return where the front touched somebody [% of its width from the right edge]; None if another part did."""
    row = (np.array([int(trajectory.length[episode])]), np.array([episode]), trajectory.touched[episode].argmax()[None])
    ahead, left = (float(column[0]) for column in in_car_frame(trajectory, *row))
    if ahead < config.car_length / 2 - ON_FRONT:
        return None
    return float(np.clip(100 * (left / config.car_width + 0.5), 0, 100))
