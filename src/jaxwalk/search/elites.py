"""The best scenarios of each cell of the grid: what a search keeps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.search.cube import Candidates
from jaxwalk.search.driving import Played
from jaxwalk.search.grid import CELLS, fails

MOST_IN_CELL = 4
"""Most scenarios that are kept in a cell, each with another key: of children with their parent's key, the best one."""


@dataclass(frozen=True, eq=False)
class Elites:
    """The best of each cell that has been reached, in the order of cells, and the best first."""

    cells: Int[np.ndarray, "elite"]
    quality: Float[np.ndarray, "elite"]
    """For a failure, the percentile of its plausibility [%]; for a near miss, minus the gap [m]. More is better."""
    candidates: Candidates
    visits: Int[np.ndarray, "cell"]
    """How often each cell of the grid has been reached."""

    @staticmethod
    def none(dimensions: int) -> Elites:
        """Return no elites."""
        nothing = np.zeros(0, np.int64)
        return Elites(
            nothing, np.zeros(0), Candidates(np.zeros((0, dimensions), np.float32), nothing), np.zeros(CELLS, np.int64)
        )

    @property
    def failed(self) -> Bool[np.ndarray, "elite"]:
        """Return which of them are failures."""
        return fails(self.cells)

    @property
    def best_failures(self) -> Bool[np.ndarray, "elite"]:
        """Return which of them is the most plausible failure of its cell."""
        return self.failed & (np.diff(self.cells, prepend=-1) > 0)

    def joined_by(self, candidates: Candidates, played: Played) -> Elites:
        """Return the elites after these candidates have been played. Of equals, the older one stays."""
        met = played.moments.cell >= 0
        quality = np.where(played.moments.failed, played.percentiles, -played.moments.gap)[met]
        cells = np.concatenate([self.cells, played.moments.cell[met]])
        every = Candidates.joined([self.candidates, candidates.some(met)])
        qualities = np.concatenate([self.quality, quality])
        best_first = np.lexsort((np.arange(len(cells)), -qualities, cells))
        families = np.stack([cells, every.keys], axis=1)[best_first]
        _, first = np.unique(families, axis=0, return_index=True)
        kept = best_first[np.sort(first)]
        begins = np.searchsorted(cells[kept], cells[kept])
        kept = kept[np.arange(len(kept)) - begins < MOST_IN_CELL]
        visits = self.visits + np.bincount(played.moments.cell[met], minlength=CELLS)
        return Elites(cells[kept], qualities[kept], every.some(kept), visits)
