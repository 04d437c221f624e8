"""Explain a failure: as few people as still fail, and of their draws as many ordinary ones as still fail."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass

import jax
import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.scenarios.archived import scenarios_at
from jaxwalk.search.cube import Candidates
from jaxwalk.search.driving import Driving, Played
from jaxwalk.search.plausibility import whose_draws
from jaxwalk.sim.scenario import dimensions, parts
from jaxwalk.sim.world import World

MIDDLE = np.float32(0.5)
"""The most ordinary value of a draw: the middle of its range, of a choice the usual one."""

Trials = Generator[Bool[np.ndarray, "trial item"], Bool[np.ndarray, "trial"], Bool[np.ndarray, "item"]]
"""Yields which items to leave out in some trials, is sent which still fail, and returns what can be left out."""


@dataclass(frozen=True, eq=False)
class Minimised:
    """Failures with as little as still fails; one row each."""

    candidates: Candidates
    present: Bool[np.ndarray, "failure ped"]
    """Who is left."""
    changed: Int[np.ndarray, "failure"]
    """How many draws of who is left had to stay as they were, of those that aren't choices among equals."""
    played: Played


def leave_out(count: int) -> Trials:
    """Find items that can be left out together, starting with all of them and then with smaller parts.

    It is the search of delta debugging (Zeller and Hildebrandt, 2002), for a set from which no single part of the last
    size can be left out.
    """
    out, size = np.zeros(count, bool), count
    while size and not out.all():
        left = np.flatnonzero(~out)
        trials = [_with(out, left[first : first + size]) for first in range(0, len(left), size)]
        fails = np.flatnonzero((yield np.array(trials)))
        if not len(fails):
            size = min(size, len(left)) // 2
            continue
        together = np.logical_or.reduce([trials[number] for number in fails])
        out = trials[fails[0]]
        if len(fails) > 1 and (yield together[None])[0]:
            out = together
    return out


def _with(out: Bool[np.ndarray, "item"], more: Int[np.ndarray, "some"]) -> Bool[np.ndarray, "item"]:
    """Return what is left out, with more items."""
    found = out.copy()
    found[more] = True
    return found


def all_at_once(
    searches: Sequence[Trials],
    try_out: Callable[[Int[np.ndarray, "trial"], list[np.ndarray]], Bool[np.ndarray, "trial"]],
) -> list[np.ndarray]:
    """Run searches side by side, so that few large batches are played; return what each returns.

    ``try_out`` is called with the number of the search that each trial is of, and the trials.
    """
    found: list[np.ndarray] = [np.zeros(0, bool)] * len(searches)
    answers: dict[int, np.ndarray | None] = dict.fromkeys(range(len(searches)))
    while answers:
        steps = {number: _next_trials(searches[number], answer) for number, answer in answers.items()}
        for number, (_, ended) in steps.items():
            found[number] = found[number] if ended is None else ended
        asked = {number: trials for number, (trials, _) in steps.items() if len(trials)}
        owners = np.repeat(np.array([*asked], np.int64), [len(trials) for trials in asked.values()])
        fails = try_out(owners, [trial for trials in asked.values() for trial in trials]) if asked else owners
        answers = {number: fails[owners == number] for number in asked}
    return found


def _next_trials(search: Trials, answer: np.ndarray | None) -> tuple[list[np.ndarray], np.ndarray | None]:
    """Return the next trials of a search, or none and what it returns at its end."""
    try:
        return list(next(search) if answer is None else search.send(answer)), None
    except StopIteration as end:
        return [], end.value


def minimise(
    game: Driving, failures: Candidates, ped: Int[np.ndarray, "failure"], tell: Callable[[int], None]
) -> Minimised:
    """Leave out people, then make draws ordinary, as long as the car still touches the same person while moving.

    Args:
        game: where they failed.
        failures: what failed.
        ped: the person that each of them touches.
        tell: called with the number of scenarios that have been played, again and again.
    """
    people = game.street.world.rules.pedestrians
    played = 0

    def still(candidates: Candidates, present: np.ndarray, touched: np.ndarray) -> Bool[np.ndarray, "trial"]:
        nonlocal played
        moments = game.play(candidates, present).moments
        played += len(candidates)
        tell(played)
        return moments.failed & (moments.ped == touched)

    others = [np.delete(np.arange(people), one) for one in ped]

    def without(owners: np.ndarray, trials: list[np.ndarray]) -> np.ndarray:
        present = np.ones((len(trials), people), bool)
        for row, (owner, trial) in enumerate(zip(owners, trials, strict=True)):
            present[row, others[owner][trial]] = False
        return still(failures.some(owners), present, ped[owners])

    left_out = all_at_once([leave_out(people - 1) for _ in ped], without)
    present = np.ones((len(ped), people), bool)
    for row, out in enumerate(left_out):
        present[row, others[row][out]] = False

    items = _draws_that_count(game, failures, present)

    def more_ordinary(owners: np.ndarray, trials: list[np.ndarray]) -> np.ndarray:
        points = failures.points[owners].copy()
        for row, (owner, trial) in enumerate(zip(owners, trials, strict=True)):
            points[row, items[owner][trial]] = MIDDLE
        return still(Candidates(points, failures.keys[owners]), present[owners], ped[owners])

    reset = all_at_once([leave_out(len(own)) for own in items], more_ordinary)
    points = failures.points.copy()
    for row, out in enumerate(reset):
        points[row, items[row][out]] = MIDDLE
    minimal = Candidates(points, failures.keys)
    changed = np.array([int((~out).sum()) for out in reset])
    return Minimised(minimal, present, changed, game.play(minimal, present))


def _draws_that_count(
    game: Driving, failures: Candidates, present: Bool[np.ndarray, "failure ped"]
) -> list[Int[np.ndarray, "draw"]]:
    """Return where in each point the draws are that mattered and that aren't choices among equals."""
    world = game.street.world
    decisions = game.play(failures, present).decisions
    where = parts(world, np.arange(dimensions(world)))
    leaders = scenarios_at(game.street, failures.points, None).leader
    whose = [
        whose_draws(None if leaders is None else np.asarray(leaders)[:, n], there, decisions[n])
        for n, there in enumerate(present)
    ]
    met = [np.arange(world.crossings)[:, None] < most for _, most in whose]
    slots = np.asarray(world.maps.slot_count)[_maps(world, failures.points)] if world.slots else np.zeros(len(present))
    return [
        np.concatenate([
            where.traits[:2, own].ravel(),
            where.jaywalk[crossings & own],
            where.zone[crossings & own],
            where.parked[: int(slot)],
        ])
        for (own, _), crossings, slot in zip(whose, met, slots, strict=True)
    ]  # fmt: skip


def _maps(world: World, points: Float[np.ndarray, "failure number"]) -> Int[np.ndarray, "failure"]:
    """Return the map of each point."""
    return np.floor(points[:, 0] * int(jax.device_get(world.map_count))).astype(np.int64)
