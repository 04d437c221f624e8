"""The best scenario of each cell of the grid: what a search keeps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from jaxwalk.search.cube import Candidates
from jaxwalk.search.driving import Played
from jaxwalk.search.grid import fails


@dataclass(frozen=True, eq=False)
class Elites:
    """One row per cell that has been reached, in the order of cells."""

    cells: Int[np.ndarray, "elite"]
    quality: Float[np.ndarray, "elite"]
    """Of a failure, the percentile of its plausibility [%]; of a near miss, minus the gap [m]. More is better."""
    candidates: Candidates

    @staticmethod
    def none(dimensions: int) -> Elites:
        """Return no elites."""
        nothing = np.zeros(0, np.int64)
        return Elites(nothing, np.zeros(0), Candidates(np.zeros((0, dimensions), np.float32), nothing))

    @property
    def failed(self) -> Bool[np.ndarray, "elite"]:
        """Return which of them are failures."""
        return fails(self.cells)

    def joined_by(self, candidates: Candidates, played: Played) -> Elites:
        """Return the elites after these candidates have been played. Of equals, the older one stays."""
        met = played.moments.cell >= 0
        quality = np.where(played.moments.failed, played.percentiles, -played.moments.gap)[met]
        cells = np.concatenate([self.cells, played.moments.cell[met]])
        every = Candidates.joined([self.candidates, candidates.some(met)])
        qualities = np.concatenate([self.quality, quality])
        best_first = np.lexsort((np.arange(len(cells)), -qualities, cells))
        _, first = np.unique(cells[best_first], return_index=True)
        kept = best_first[first]
        return Elites(cells[kept], qualities[kept], every.some(kept))
