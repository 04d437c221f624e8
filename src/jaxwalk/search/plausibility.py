"""How ordinary a scenario is: its percentile among ordinary ones, by the draws that mattered.

A draw that is a number counts by the square of its normal score. A choice counts by its probability: as the square of
the normal score whose two tails are as likely as what happened, or anything rarer (and half of what is equally likely).
Choices among equals, such as the street, say nothing. The sum is compared with that of fresh draws of the same numbers
and choices, so the percentile is uniform for ordinary scenarios.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import jax
import numpy as np
import scipy
from jaxtyping import Bool, Float, Int

from jaxwalk.sim.environment import Street
from jaxwalk.sim.person_kind import begins
from jaxwalk.sim.scenario import FINEST, Scenario
from jaxwalk.sim.walking_groups import LARGEST, chances
from jaxwalk.sim.world import World

FRESH = 4000
"""Number of fresh draws with which a scenario is compared."""
SEED = 0
"""Their seed: a percentile is always the same number."""


@dataclass(frozen=True)
class ChoiceMade:
    """A choice that was made several times."""

    probabilities: tuple[float, ...]
    """The probability of each outcome."""
    counts: tuple[int, ...]
    """How often each came."""


@dataclass(frozen=True)
class DrawsUsed:
    """The draws of a scenario that mattered."""

    numbers: Float[np.ndarray, "number"]
    """Normal scores of draws that are numbers."""
    choices: tuple[ChoiceMade, ...]


def percentile(used: DrawsUsed, fresh: int = FRESH) -> float:
    """Return the share of ordinary scenarios that are at least as unusual [%].

    100: nothing is more ordinary. Below 1, fewer than one in a hundred are as unusual.
    """
    rng = np.random.default_rng(SEED)
    own, others = float((used.numbers**2).sum()), np.zeros(fresh)
    if len(used.numbers):
        others += rng.chisquare(len(used.numbers), fresh)
    for choice in used.choices:
        squares = equivalent_squares(choice.probabilities)
        own += float(np.dot(choice.counts, squares))
        others += rng.multinomial(sum(choice.counts), choice.probabilities, fresh) @ squares
    return float(100 * (others >= own - 1e-9).mean())


def equivalent_squares(probabilities: Sequence[float]) -> Float[np.ndarray, "outcome"]:
    """Return for each outcome of a choice the square of the normal score that is as unusual."""
    chance = np.asarray(probabilities, np.float64)
    rarer = (chance[None] < chance[:, None] - 1e-12) @ chance
    alike = (np.abs(chance[None] - chance[:, None]) <= 1e-12) @ chance
    return scipy.stats.chi2.isf(rarer + alike / 2, 1)


def draws_used(
    street: Street, scenarios: Scenario, decisions: Int[np.ndarray, "episode ped"], chosen: Sequence[int]
) -> list[DrawsUsed]:
    """Return the draws of some episodes that mattered.

    Those of people who aren't there didn't, and those of crossings that nobody came to didn't either.

    Args:
        street: the world.
        scenarios: a batch, arrays ``(..., episode)``.
        decisions: crossings that each person had decided about at the episode's end.
        chosen: the episodes.
    """
    tendency = np.asarray(scenarios.jaywalking_tendency(street.world))
    plain: Scenario = jax.tree.map(np.asarray, scenarios)
    slots = np.asarray(street.world.maps.slot_count)[plain.map]
    return [_used(street.world, _of_episode(plain, tendency, decisions, one), int(slots[one])) for one in chosen]


def whose_draws(
    leader: Int[np.ndarray, "ped"] | None, there: Bool[np.ndarray, "ped"], decisions: Int[np.ndarray, "ped"]
) -> tuple[Bool[np.ndarray, "ped"], Int[np.ndarray, "ped"]]:
    """Return whose draws matter in an episode, and for how many crossings.

    Who walks in a group moves by its leader's draws, even where the leader isn't there. ``leader``: each person's, None
    without groups.
    """
    if leader is None:
        return there, decisions
    own, most = np.zeros_like(there), np.zeros_like(decisions)
    own[leader[there]] = True
    np.maximum.at(most, leader[there], decisions[there])
    return own, most


@dataclass(frozen=True)
class _Drawn:
    """What was drawn of one episode."""

    scenario: Scenario
    """Arrays ``(...)``."""
    chance: Float[np.ndarray, "ped"]
    """Probability that a crossing is a jaywalk, before the multiplier."""
    decisions: Int[np.ndarray, "ped"]
    there: Bool[np.ndarray, "ped"]


def _of_episode(scenarios: Scenario, tendency: np.ndarray, decisions: np.ndarray, episode: int) -> _Drawn:
    one: Scenario = jax.tree.map(lambda column: column[..., episode], scenarios)
    there = np.ones(len(one.start), bool) if one.absent is None else ~np.asarray(one.absent)
    return _Drawn(one, tendency[:, episode], decisions[episode], there)


def _used(world: World, drawn: _Drawn, slots: int) -> DrawsUsed:
    """Return the draws of one episode that mattered, on a map with this many parking slots."""
    rules, one = world.rules, drawn.scenario
    chance = np.clip(drawn.chance * float(rules.jaywalk_multiplier), 0, 1)
    own, decisions = whose_draws(None if one.leader is None else np.asarray(one.leader), drawn.there, drawn.decisions)
    met = (np.arange(world.crossings)[:, None] < decisions) & own
    jaywalks = met & (one.jaywalk_draw < chance)
    kinds = begins(rules.kinds) if rules.kinds else ()
    scores = _scores(np.asarray(one.traits), rules.pace_correlation)
    numbers = [scores[1][own], _normal(np.asarray(one.zone_draw))[jaywalks]] + ([] if kinds else [scores[0][own]])
    choices = [*_yes_or_no(np.broadcast_to(chance, met.shape)[met], jaywalks[met])]
    if kinds:
        shares = np.array([kind.share for kind in rules.kinds])
        which = np.searchsorted(kinds, np.asarray(one.traits[0])[own], side="right") - 1
        counts = np.bincount(which, minlength=len(shares))
        choices.append(ChoiceMade(tuple(shares / shares.sum()), tuple(counts.tolist())))
    if one.parked is not None:
        stands = int(np.asarray(one.parked)[:slots].sum())
        choices += _binary(float(rules.parked), stands, slots - stands)
    if one.earlier_draw is not None:
        earlier = np.broadcast_to(own, one.earlier_draw.shape)
        chances_then = np.broadcast_to(chance, earlier.shape)
        choices += _yes_or_no(chances_then[earlier], (np.asarray(one.earlier_draw) < chance)[earlier])
    if one.leader is not None:
        choices += _groups(np.asarray(one.leader), rules.grouped)
    return DrawsUsed(np.concatenate(numbers).astype(np.float64), tuple(choices))


def _scores(traits: Float[np.ndarray, "trait ped"], correlation: float) -> Float[np.ndarray, "2 ped"]:
    """Return the independent normal scores behind the first two traits."""
    first, second = _normal(traits[0]), _normal(traits[1])
    if not correlation:
        return np.stack([first, second])
    rest = np.sqrt(1 - correlation**2)
    return np.stack([first, (second - correlation * first) / rest if rest else np.zeros_like(first)])


def _normal(uniform: np.ndarray) -> np.ndarray:
    return scipy.special.ndtri(np.clip(np.asarray(uniform, np.float64), FINEST, 1 - FINEST))


def _yes_or_no(chance: Float[np.ndarray, "choice"], came: Bool[np.ndarray, "choice"]) -> Iterator[ChoiceMade]:
    """Yield what was decided with each probability."""
    for one in np.unique(chance):
        mine = came[chance == one]
        yield from _binary(float(one), int(mine.sum()), int((~mine).sum()))


def _binary(chance: float, came: int, didnt: int) -> Iterator[ChoiceMade]:
    """Yield a choice between yes and no, unless one of them is certain."""
    if 0 < chance < 1 and came + didnt:
        yield ChoiceMade((chance, 1 - chance), (came, didnt))


def _groups(leader: Int[np.ndarray, "ped"], grouped: float) -> Iterator[ChoiceMade]:
    """Yield how many of each three people walk together: all, two or nobody."""
    whole = len(leader) // LARGEST
    follows = (leader != np.arange(len(leader)))[: whole * LARGEST].reshape(-1, LARGEST).sum(axis=1)
    three, two = chances(grouped)
    counts = tuple(int((follows == number).sum()) for number in (2, 1, 0))
    if whole:
        yield ChoiceMade((three, two, 1 - three - two), counts)
    if len(leader) % LARGEST == 2:
        together = int(leader[-1] == len(leader) - 2)
        yield from _binary(grouped, together, 1 - together)
