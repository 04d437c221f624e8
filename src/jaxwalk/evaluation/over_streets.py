"""Numbers of drivers on many streets: what to expect of another training, on other streets.

A street is the unit: episodes on one street have its difficulty in common.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Int

from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.evaluation.training_seeds import Match
from jaxwalk.metrics import FEWEST_SEEDS, OUTCOMES, crossed_mean, over_seeds
from jaxwalk.metrics.contacts import touched_while_moving
from jaxwalk.metrics.counts import clustered_share
from jaxwalk.metrics.over_seeds import linear_part
from jaxwalk.metrics.statistics import episode_sums, ratio

Counted = Literal["goal", "touched"]
"""What is counted: episodes that reach the goal; those in which the moving car touches somebody by its footprint."""


@dataclass(frozen=True)
class StreetScores:
    """How one driver's episodes ended on each street of a set: a number for each street."""

    driver: str
    training_seed: int | None
    """None if nobody trained it."""
    episodes: tuple[int, ...]
    goal: tuple[int, ...]
    """Episodes that reach the goal."""
    touched: tuple[int, ...]
    """Episodes in which the moving car touches somebody by its footprint."""


@dataclass(frozen=True)
class StreetSet:
    """Some streets with a number of people, and everybody's scores there."""

    name: str
    people: int
    streets: tuple[str, ...]
    """Names of the streets, in the order of the scores."""
    scores: tuple[StreetScores, ...]


def scores_of(match: Match, streets: Sequence[str]) -> StreetScores:
    """Return a driver's scores on these streets. Raise ValueError if it isn't known which episode was on which."""
    rows = match.rows
    if rows.maps is None:
        raise ValueError("it isn't known on which street each episode was")
    place = {name: number for number, name in enumerate(streets)}
    where = np.array([place[name] for name in rows.maps])

    def count(which: np.ndarray) -> tuple[int, ...]:
        return tuple(np.bincount(where[which], minlength=len(streets)).tolist())

    everywhere = np.ones(rows.episodes, bool)
    goal, touched = rows[OUTCOMES].goal, touched_while_moving(rows)
    return StreetScores(
        match.cell.driver, match.cell.training_seed, *map(count, (everywhere, np.asarray(goal, bool), touched))
    )


def share(scores: Sequence[StreetScores], counted: Counted) -> Interval:
    """Return the mean over training seeds of the share of episodes, with its interval for other streets and seeds.

    ``scores`` has an entry for each training seed, all on the same streets: a two-way analysis of variance, as
    `jaxwalk.metrics.over_seeds` makes it. Of a driver that nobody trained it is that of `clustered_share`, with streets
    in the place of episodes. There is no interval with fewer training seeds than `FEWEST_SEEDS`, and for a rule none on
    a single street.
    """
    over, under = _counts(scores, counted)
    if scores[0].training_seed is None:
        return _of_rule(over[0], under[0])
    return Interval.of(over_seeds(over, under, kind="share").mean)


def _of_rule(over: Int[np.ndarray, "street"], under: Int[np.ndarray, "street"]) -> Interval:
    sums = episode_sums({"over": over, "under": under})
    found = clustered_share(ratio(sums["over"], sums["under"]), int(under.sum()), len(under))
    return Interval.of(found) if len(under) > 1 else Interval(found.value, None, None)


def gap(trained: Sequence[StreetScores], tested: Sequence[StreetScores], counted: Counted) -> Interval:
    """Return the share on the streets that each car was trained on, minus its share on the test's streets.

    Both have an entry for each training seed; a seed's own streets are part of what differs among seeds. There is no
    interval with fewer seeds than `FEWEST_SEEDS`, or where nothing differs. Raise ValueError for other seeds.
    """
    if [one.training_seed for one in trained] != [one.training_seed for one in tested]:
        raise ValueError("both sides must have the same training seeds in the same order")
    at_home = np.array([sum(getattr(one, counted)) / sum(one.episodes) for one in trained])
    away = linear_part(*_counts(tested, counted))
    value = float(at_home.mean() - away.mean())
    found = crossed_mean(at_home[:, None] - away) if len(trained) >= FEWEST_SEEDS else None
    return Interval(value, *(found.ends() if found is not None and found.error > 0 else (None, None)))


def _counts(
    scores: Sequence[StreetScores], counted: Counted
) -> tuple[Int[np.ndarray, "seed street"], Int[np.ndarray, "seed street"]]:
    """Return the counted episodes and all episodes."""
    return np.array([getattr(one, counted) for one in scores]), np.array([one.episodes for one in scores])
