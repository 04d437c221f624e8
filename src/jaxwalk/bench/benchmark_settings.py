"""What a benchmark measures, and for how long. No JAX import."""

from __future__ import annotations

import math
from dataclasses import dataclass

PARTS = ("env", "train", "compile", "pedestrians")
"""What can be asked for: the simulator alone, training, the first minute, and the cost of a crowd."""


@dataclass(frozen=True)
class Settings:
    """Impossible values raise ValueError, naming the field."""

    only: tuple[str, ...] = PARTS
    """Parts to measure."""
    environments: tuple[int, ...] = (64, 256, 512, 1024, 2048, 4096, 16384)
    """Environments side by side: a row each, of the simulator alone."""
    training_environments: tuple[int, ...] = (128, 512, 2048)
    """The same, of training with the recipe ``fast``; each recipe's own number is measured in any case."""
    recipe_environments: int | None = None
    """Instead of each recipe's own number (`QUICK` only: its figures are no measure of the recipes)."""
    pedestrians: tuple[int, ...] = (12, 24, 48, 96)
    """People in an episode: a row each."""
    crowd_environments: int = 256
    """Environments side by side in those rows."""
    steps: int = 256
    """Steps in one call, of the simulator alone."""
    products: tuple[int, ...] = (512, 1024, 2048, 4096)
    """Sides of the square matrices whose product is the machine's peak."""
    seconds: float = 3.0
    """Each row is measured for at least so long [s], after compiling."""
    chunk_rows: int | None = None
    """`TrainConfig.chunk_rows`; None: the recipe's, but a whole minibatch on an accelerator."""
    seed: int = 0
    """Of scenarios, networks and actions."""
    quick: bool = False
    """Few sizes and short times: only shows that everything can be measured."""

    def __post_init__(self) -> None:
        """Refuse what can't be measured."""
        for name in ("environments", "training_environments", "pedestrians"):
            _require(len(getattr(self, name)) > 0, name, "needs at least one number")
            smallest = min(getattr(self, name))
            _require(smallest >= 1, name, f"must be at least 1, not {smallest}")
        _require(0 <= self.seconds < math.inf, "seconds", f"must be 0 or more, not {self.seconds}")
        _require(0 <= self.seed < 2**31, "seed", f"must lie in [0, 2^31), not {self.seed}")
        _require(len(self.only) > 0, "only", f"needs at least one part: {', '.join(PARTS)}")
        unknown = [part for part in self.only if part not in PARTS]
        _require(not unknown, "only", f"knows {', '.join(PARTS)}, not {', '.join(unknown)}")
        rows = self.chunk_rows
        _require(rows is None or rows >= 1, "chunk_rows", f"must be at least 1, not {rows}")


QUICK = {
    "environments": (64,),
    "training_environments": (32,),
    "recipe_environments": 32,
    "pedestrians": (12, 48),
    "crowd_environments": 64,
    "products": (512, 1024),
    "steps": 64,
    "seconds": 0.2,
    "quick": True,
}
"""What ``--quick`` changes."""


def _require(condition: bool, name: str, message: str) -> None:
    if not condition:
        raise ValueError(f"{name} {message}")
