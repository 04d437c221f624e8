"""Read raters' files of answers, which come from anybody: each is whole and of the plan, or refused in one message."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Literal

from jaxwalk.evaluation.reading import Origin, as_document
from jaxwalk.raters.rating_plan import SCHEMA, RatingPlan, Side

LARGEST_FILE = 1_000_000
"""Larger files are no answers [bytes]."""
ADVICE = "ask the rater to send the file again, or leave it out"
ID_LENGTH = 16
"""Hexadecimal digits of a rater's random id."""
Choice = Literal["left", "right", "equal"]


class AnswersError(ValueError):
    """Raised for a file that has no answers to the plan; the message names the file and says what to do."""


@dataclass(frozen=True)
class RaterAnswer:
    """One answer."""

    pair: int
    """Place of the pair in the plan."""
    left: Side
    """The clip that was shown on the left."""
    answer: Choice
    seconds: float
    """From the first sight of the pair to the answer."""
    repeat: bool
    """Whether the rater saw the pair for the second time."""

    @property
    def value(self) -> int:
        """1 if clip a was preferred, -1 if clip b was, 0 if neither."""
        if self.answer == "equal":
            return 0
        return 1 if (self.answer == "left") == (self.left == "a") else -1


@dataclass(frozen=True)
class RaterFile:
    """What a rater sent."""

    __pydantic_config__: ClassVar = {"extra": "forbid", "strict": True}

    schema: int
    plan: str
    """The plan's id."""
    rater: str
    """A random id, which the page made."""
    adult: bool
    consent: bool
    answers: tuple[RaterAnswer, ...]

    def __post_init__(self) -> None:
        """Raise ValueError for answers that no rater's page could have given."""
        if self.schema != SCHEMA:
            raise ValueError(f"is of another version: its schema is {self.schema}, not {SCHEMA}")
        if len(self.rater) != ID_LENGTH or set(self.rater) - set("0123456789abcdef"):
            raise ValueError(f"the rater's id is not {ID_LENGTH} hexadecimal digits")
        if not (self.adult and self.consent):
            raise ValueError("the rater did not say to be 18 or older and to consent")
        first = [one.pair for one in self.answers if not one.repeat]
        again = [one.pair for one in self.answers if one.repeat]
        if len(set(first)) < len(first) or len(set(again)) < len(again) or not set(again) <= set(first):
            raise ValueError("a pair is answered twice")
        if any(one.seconds < 0 for one in self.answers):
            raise ValueError("an answer took less than no time")


def read_answers(paths: Sequence[Path], plan: RatingPlan) -> tuple[RaterFile, ...]:
    """Read files of answers to a plan.

    Raises:
        AnswersError: a file is too large, no JSON, of another plan, or has a pair that the plan lacks; or two files are
            of one rater.
        DocumentError: a file is damaged.
    """
    found: dict[str, Path] = {}
    answers = []
    for path in paths:
        one = _read(path, plan)
        if one.rater in found:
            raise AnswersError(
                f"{path}: is of the same rater as {found[one.rater]} ({one.rater}); leave one of them out"
            )
        found[one.rater] = path
        answers.append(one)
    return tuple(answers)


def _read(path: Path, plan: RatingPlan) -> RaterFile:
    size = path.stat().st_size
    if size > LARGEST_FILE:
        raise AnswersError(f"{path}: has {size:,} bytes, and answers at most {LARGEST_FILE:,}; {ADVICE}")
    try:
        content = json.loads(path.read_bytes())
    except (ValueError, RecursionError) as error:
        raise AnswersError(f"{path}: is no JSON document ({error}); {ADVICE}") from error
    one = as_document(RaterFile, content, Origin(path, ADVICE))
    if one.plan != plan.id:
        raise AnswersError(f"{path}: answers the page of another plan ({one.plan:.40}), not of {plan.id}; leave it out")
    for answer in one.answers:
        if not 0 <= answer.pair < len(plan.pairs):
            raise AnswersError(f"{path}: answers pair {answer.pair}, and the plan has {len(plan.pairs)}; {ADVICE}")
    return one
