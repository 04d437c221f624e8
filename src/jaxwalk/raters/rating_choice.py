"""Choose what raters see: scenarios in which a car meets somebody, and checks that nobody gets wrong; our numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from math import ceil

import numpy as np

from jaxwalk.evaluation.document_parts import Number
from jaxwalk.metrics import COMFORT, DELAY, ENCOUNTERS, IMPACT_TAIL, NEAR_MISSES, OUTCOMES, Rows, Summary
from jaxwalk.raters.rating_plan import DriverMeasure, RatedPair, RatingError, Side

CHECKS = 2
"""Checks in a plan."""
CLIPS = 3
"""Scenarios of every two drivers, at least."""
LEAD = 1.0
"""A clip begins this long before the car is near somebody who crosses [s]."""
BEFORE_HIT = 6.0
"""A check begins this long before its hit [s], which is within the length of a clip."""
CLEAR = 1.0
"""In a check, the other car keeps this much away from everybody who crosses [m]."""


def choose_pairs(rows: Mapping[str, Rows], rated: int, *, each: int, seed: int) -> tuple[RatedPair, ...]:
    """Return the pairs of a plan: as many of every two drivers, then the checks.

    A pair's scenario is drawn from those in which a car of the two meets somebody; both clips begin when the nearer of
    their encounters does, which is before either episode ends.

    Args:
        rows: what was measured of each player on the same scenarios; the rated drivers come first.
        rated: number of the rated drivers.
        each: pairs that each rater sees.
        seed: seed of the draws.

    Raises:
        RatingError: there are too few scenarios with an encounter, or none for a check.
    """
    rng = np.random.default_rng(seed)
    names, duos = list(rows), list(combinations(range(rated), 2))
    count = max(CLIPS, ceil(each / len(duos)))
    pairs = []
    for a, b in duos:
        duo = rows[names[a]], rows[names[b]]
        begins = _before_the_end(_nearer(*map(_nearest, duo)), duo)
        if len(begins) < count:
            raise RatingError(
                f"{names[a]} and {names[b]} meet somebody in {len(begins)} scenarios, and {count} are needed; take "
                "more --episodes, or fewer --pairs"
            )
        for scenario in rng.choice(sorted(begins), size=count, replace=False).tolist():
            first, second = (a, b) if rng.random() < 0.5 else (b, a)
            pairs.append(RatedPair(scenario, first, second, round(max(0.0, begins[scenario][1] - LEAD), 1)))
    return (*pairs, *_checks(rows))


Nearest = dict[int, tuple[float, float]]
"""By scenario: the smallest gap of an encounter [m], and when that encounter begins [s]."""


def _nearest(rows: Rows) -> Nearest:
    """Return the nearest encounter of each scenario that has one."""
    found = rows[ENCOUNTERS]
    columns = (found.scenario.tolist(), found.min_gap.tolist(), (found.start * rows.dt).tolist())
    nearest: Nearest = {}
    for scenario, gap, start in zip(*columns, strict=True):
        nearest[scenario] = min(nearest.get(scenario, (float("inf"), 0.0)), (gap, start))
    return nearest


def _nearer(a: Nearest, b: Nearest) -> Nearest:
    """Return the nearer encounter of both in each scenario."""
    far = (float("inf"), 0.0)
    return {scenario: min(a.get(scenario, far), b.get(scenario, far)) for scenario in a.keys() | b.keys()}


def _before_the_end(begins: Nearest, rows: Sequence[Rows]) -> Nearest:
    """Return the encounters that begin while all episodes of their scenario go on."""
    ends = np.min([one[OUTCOMES].steps * one.dt for one in rows], axis=0)
    return {scenario: (gap, start) for scenario, (gap, start) in begins.items() if start < ends[scenario]}


def _checks(rows: Mapping[str, Rows]) -> Iterator[RatedPair]:
    """Yield the checks: one car hits somebody, fast, and the other one passes everybody and arrives."""
    names, used = list(rows), set()
    nearest = {name: _nearest(found) for name, found in rows.items()}
    for _, scenario, hitter in sorted(_hits(rows), reverse=True):
        careful = next((k for k, name in enumerate(names) if _keeps_clear(rows[name], nearest[name], scenario)), None)
        if careful is None or scenario in used or len(used) == CHECKS:
            continue
        used.add(scenario)
        end = float(rows[names[hitter]][OUTCOMES].steps[scenario] * rows[names[hitter]].dt)
        safer: Side = "a" if len(used) % 2 else "b"
        sides = (careful, hitter) if safer == "a" else (hitter, careful)
        yield RatedPair(scenario, *sides, round(max(0.0, end - BEFORE_HIT), 1), safer)
    if len(used) < CHECKS:
        raise RatingError(
            f"only {len(used)} of {CHECKS} checks can be made: in no other scenario one car hits somebody and another "
            "one keeps clear of everybody; take more --episodes, or a driver that is more careful"
        )


def _hits(rows: Mapping[str, Rows]) -> list[tuple[float, int, int]]:
    """Return speed, scenario and player of every hit by a moving car."""
    found = []
    for player, measured in enumerate(rows.values()):
        table = measured[OUTCOMES]
        hit = np.flatnonzero(table.moving)
        found += [(float(table.impact_speed[k]), int(table.scenario[k]), player) for k in hit]
    return found


def _keeps_clear(rows: Rows, nearest: Nearest, scenario: int) -> bool:
    return bool(rows[OUTCOMES].goal[scenario]) and nearest.get(scenario, (float("inf"), 0.0))[0] > CLEAR


def measures_of(summaries: Sequence[Summary]) -> tuple[DriverMeasure, ...]:
    """Return our numbers of the rated drivers, in their order."""
    found: dict[str, tuple[bool, list[Number]]] = {
        "hits": (False, [s[OUTCOMES].moving.per_episode for s in summaries]),
        "hits foretold by near misses": (False, [s[NEAR_MISSES].extrapolated for s in summaries]),
        "speed in the worst hundredth of contacts": (False, [s[IMPACT_TAIL].worst_hundredth for s in summaries]),
        "gap that one in twenty encounters falls below": (True, [s[ENCOUNTERS].jaywalk.minimum_gap for s in summaries]),
        "harsh braking": (False, [s[COMFORT].harsh for s in summaries]),
        "delay": (True, [s[DELAY].mean for s in summaries]),
    }
    return tuple(DriverMeasure(name, high, tuple(x.value for x in values)) for name, (high, values) in found.items())
