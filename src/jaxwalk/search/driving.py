"""Play candidates with a driver, and find their critical moments."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.evaluation.batches import AT_ONCE, BATCH, episodes_at_once
from jaxwalk.evaluation.playing import play
from jaxwalk.interfaces import Policy, Roles
from jaxwalk.scenarios.archived import keys_of, scenarios_at
from jaxwalk.search.critical import CriticalMoments, critical_moments
from jaxwalk.search.cube import Candidates
from jaxwalk.search.plausibility import draws_used, percentile
from jaxwalk.sim.environment import Street
from jaxwalk.sim.scenario import dimensions

SMALL_PART = 64
"""Candidates that are played at once where there are few."""


@dataclass(frozen=True, eq=False)
class Played:
    """What happened to candidates."""

    moments: CriticalMoments
    percentiles: Float[np.ndarray, "candidate"]
    """How ordinary each failure is [%] (`jaxwalk.search.plausibility`); NaN for what didn't fail."""
    decisions: Int[np.ndarray, "candidate ped"]
    """How many crossings each person had decided about at the end."""


class Driving:
    """A driver among people on a street, as something that can be searched."""

    def __init__(self, street: Street, policies: Roles[Policy], seed: int, *, batch: int = BATCH) -> None:
        """Play with these policies, and with keys of this seed; a generation of a search has ``batch`` candidates.

        As many are played at once as in an evaluation, so that it plays the same, to the last bit; but not more than
        a generation has.
        """
        self.street, self.policies, self.seed, self.batch = street, policies, seed, batch
        self.at_once = min(batch, episodes_at_once(street, policies))
        """How many candidates are played at once."""
        self.dimensions = dimensions(street.world)
        """How many numbers a point has."""
        self._compiled: set[bool] = set()

    def play(self, candidates: Candidates, present: Bool[np.ndarray, "candidate ped"] | None = None) -> Played:
        """Play candidates to their ends. Only those who are ``present`` are there (default: everybody).

        Raises:
            DriverError: a driver that is not JAX failed.
            ActionError: an action of another policy isn't in its space.
        """
        firsts = list(range(0, len(candidates), self.at_once))
        parts = []
        if (present is None) not in self._compiled:  # alone, so that its programs are compiled only once
            self._compiled.add(present is None)
            parts.append(self._part(candidates, present, firsts.pop(0)))
        with ThreadPoolExecutor(AT_ONCE) as pool:
            parts += pool.map(lambda first: self._part(candidates, present, first), firsts)
        moments = CriticalMoments.joined([part.moments for part in parts])
        columns = ([getattr(part, name) for part in parts] for name in ("percentiles", "decisions"))
        return Played(moments, *map(np.concatenate, columns))

    def score(self, candidates: Candidates) -> Float[np.ndarray, "candidate"]:
        """Return minus what was missing to a contact of the moving car [m]; 0 for a failure."""
        return self.play(candidates).moments.score

    def _part(self, candidates: Candidates, present: np.ndarray | None, first: int) -> Played:
        """Return what happened to a batch; the last one is filled up, so that nothing is compiled again."""
        rows = np.arange(first, min(first + self.at_once, len(candidates)))
        full = np.resize(rows, self.at_once)
        absent = None if present is None else ~present[full].T
        scenarios = scenarios_at(self.street, candidates.points[full], absent)
        trajectory = play(self.street, self.policies, scenarios, keys_of(self.seed, candidates.keys[full]))
        asked = slice(len(rows))
        moments = critical_moments(self.street, trajectory).some(asked)
        decisions = trajectory.decisions[trajectory.length, np.arange(self.at_once)]
        percentiles, failed = np.full(len(rows), np.nan), np.flatnonzero(moments.failed)
        used = draws_used(self.street, scenarios, decisions, failed.tolist()) if len(failed) else []
        percentiles[failed] = [percentile(one) for one in used]
        return Played(moments, percentiles, decisions[asked].astype(np.int64))
