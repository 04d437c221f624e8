"""Options of the command that draws, lists and checks generated streets."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from jaxwalk.cli.options.declare import option
from jaxwalk.maps.generated import SPLITS

if TYPE_CHECKING:
    SplitName = str
else:
    SplitName = Literal[tuple(SPLITS)]
"""The name of a split."""


@dataclass(frozen=True)
class Streets:
    """Draw, list and check generated streets: each is made from a number. See docs/streets.md.

    For example: jaxwalk streets --split test --count 12 --out streets
    """

    split: Annotated[SplitName, option("training")] = "training"
    """Which numbers: training, validation and test never meet; unseen-ranges are streets whose parameters lie outside
    those of all three, arterial wide and fast ones, parked-training and parked-test narrow ones."""
    first: Annotated[int, option("0", "N")] = 0
    """Begin at this place among the split's numbers, from 0."""
    count: Annotated[int, option("12", "N")] = 12
    """Number of streets. Numbers that give none are left out, and counted."""
    out: Annotated[Path | None, option("none: only list them", "DIR")] = None
    """Folder for a picture of each street, NUMBER.png, and streets.png with all of them; older ones are replaced."""
    check: Annotated[int | None, option("none", "N")] = None
    """Instead, make this many numbers: how many give a street, why the others don't, and the time of each."""
