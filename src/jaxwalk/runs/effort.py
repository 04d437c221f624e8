"""How much work a study does, with the largest numbers. This module imports no JAX."""

from __future__ import annotations

from dataclasses import dataclass

MOST_EPISODES = 10_000_000
"""Most scenarios of a cell: their rows, about 1 kB each, are kept in memory."""
MOST_SEEDS = 1000
"""Most training seeds of a study."""


@dataclass(frozen=True)
class Effort:
    """How much work to do: what every plan has. Raises ValueError for an impossible value, naming the field."""

    updates: int | None = None
    """Number of updates of each training."""
    episodes: int = 1000
    """Number of scenarios in each cell."""
    seed: int = 0
    """Seed of the scenarios, and the first training seed."""
    seeds: int = 1
    """Number of training seeds: ``seed``, ``seed`` + 1, ..."""

    def __post_init__(self) -> None:
        """Raise ValueError for an impossible value."""
        if self.updates is not None and not 1 <= self.updates < 2**31:
            raise ValueError(f"updates must lie in [1, 2^31), not {self.updates}")
        for name, most in (("episodes", MOST_EPISODES), ("seeds", MOST_SEEDS)):
            if not 1 <= getattr(self, name) <= most:
                raise ValueError(f"{name} must lie in [1, {most:,}], not {getattr(self, name):,}")
        if not 0 <= self.seed < 2**31:
            raise ValueError(f"seed must lie in [0, 2^31), not {self.seed}")
        if self.seed + self.seeds > 2**31:
            raise ValueError(f"seed + seeds must be at most 2^31, not {self.seed} + {self.seeds}")

    @property
    def training_seeds(self) -> range:
        """Return all training seeds."""
        return range(self.seed, self.seed + self.seeds)
