"""What a benchmark measures, and for how long. This module imports no JAX."""

from __future__ import annotations

from dataclasses import dataclass

from jaxwalk.sim.suites import SUITES

PARTS = ("env", "train", "compile", "pedestrians", "streets", "suites")
"""The parts: the simulator alone, training, the first minute, the cost of a crowd, of many streets and of suites."""
MOST = {
    "environments": 2**20,
    "training_environments": 2**20,
    "pedestrians": 1000,
    "streets": 1000,
    "suite_pedestrians": 1000,
}
"""Largest numbers of environments, of people in an episode, and of streets."""
HERE = "here"
"""The plan for this machine's own GPU, on which its programs run, too."""
PLANNED = {"h100": {"environments": (512, 2048, 16384, 65536)}, HERE: {"environments": (512, 2048, 16384, 65536)}}
"""GPUs for which programs are planned, and the values that settings for their plan have."""
LONGEST = 3600
"""Longest time for which a row is measured [s]."""


@dataclass(frozen=True)
class Settings:
    """The settings of a benchmark. Raises ValueError for an impossible value, naming the field."""

    only: tuple[str, ...] = PARTS
    """Parts to measure."""
    environments: tuple[int, ...] = (64, 256, 512, 1024, 2048, 4096, 16384)
    """Numbers of environments for the simulator alone; a row for each."""
    training_environments: tuple[int, ...] = (128, 512, 2048)
    """Numbers of environments for training with the recipe ``fast``; each recipe's own number is always measured."""
    recipe_environments: int | None = None
    """Replaces each recipe's own number of environments (only `QUICK`, whose figures don't measure the recipes)."""
    pedestrians: tuple[int, ...] = (12, 24, 48, 96)
    """Numbers of pedestrians in an episode; a row for each."""
    crowd_environments: int = 256
    """Number of environments in those rows."""
    streets: tuple[int, ...] = (1, 64, 256)
    """Numbers of generated streets; a row for each."""
    street_environments: int = 1024
    """Number of environments in those rows."""
    suites: tuple[str, ...] = ("paper", "town", "blind-corner", "arterial")
    """Suites whose world and streets are simulated; a row for each, with each of the following numbers of people."""
    suite_pedestrians: tuple[int, ...] = (12, 24)
    """Numbers of pedestrians in those rows."""
    suite_environments: int = 1024
    """Number of environments in those rows."""
    turns: int = 20
    """Turns that the programs take which are compared."""
    turn_seconds: float = 1.0
    """Shortest time of such a turn [s]."""
    steps: int = 256
    """Steps in one call of the simulator alone."""
    products: tuple[int, ...] = (512, 1024, 2048, 4096)
    """Sizes of the square matrices whose product gives the machine's peak."""
    seconds: float = 3.0
    """Shortest time for which each row is measured, after compiling [s]."""
    chunk_rows: int | None = None
    """`TrainConfig.chunk_rows`; None: the recipe's value, or a whole minibatch on an accelerator."""
    seed: int = 0
    """Seed of scenarios, networks and actions."""
    quick: bool = False
    """Few sizes and short times: shows only that everything can be measured."""
    plan: str | None = None
    """The GPU for which programs are compiled (`PLANNED`), instead of measuring this machine's parts."""
    plan_environments: int = 16384
    """Number of environments of a rollout that is compiled for it."""

    def __post_init__(self) -> None:
        """Raise ValueError for an impossible value."""
        for name in ("environments", "training_environments", "pedestrians", "streets", "suite_pedestrians"):
            _require(len(getattr(self, name)) > 0, name, "needs at least one number")
            wrong = [number for number in getattr(self, name) if not 1 <= number <= MOST[name]]
            _require(not wrong, name, f"must lie in [1, {MOST[name]:,}], not {wrong[:1]}")
        _require(0 <= self.seconds <= LONGEST, "seconds", f"must lie in [0, {LONGEST:,}], not {self.seconds:g}")
        _require(0 <= self.seed < 2**31, "seed", f"must lie in [0, 2^31), not {self.seed}")
        _require(len(self.only) > 0, "only", f"needs at least one part: {', '.join(PARTS)}")
        unknown = [part for part in self.only if part not in PARTS]
        _require(not unknown, "only", f"knows {', '.join(PARTS)}, not {', '.join(unknown)}")
        _require(len(self.suites) > 0, "suites", f"needs at least one suite: {', '.join(SUITES)}")
        unknown = [suite for suite in self.suites if suite not in SUITES]
        _require(not unknown, "suites", f"knows {', '.join(SUITES)}, not {', '.join(unknown)}")
        rows = self.chunk_rows
        _require(rows is None or 1 <= rows < 2**31, "chunk_rows", f"must lie in [1, 2^31), not {rows}")


QUICK = {
    "environments": (64,),
    "training_environments": (32,),
    "recipe_environments": 32,
    "pedestrians": (12, 48),
    "crowd_environments": 64,
    "streets": (1, 2),
    "street_environments": 64,
    "suites": ("paper",),
    "suite_environments": 64,
    "turns": 2,
    "turn_seconds": 0.1,
    "products": (512, 1024),
    "steps": 64,
    "seconds": 0.2,
    "quick": True,
}
"""Values that ``--quick`` changes."""


def _require(condition: bool, name: str, message: str) -> None:
    if not condition:
        raise ValueError(f"{name} {message}")
