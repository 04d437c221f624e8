"""What a command can require of drivers in crash tests, such as ``avoid<=40``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from jaxwalk.evaluation.crash_outcomes import CrashOutcome
from jaxwalk.scenarios.staging import Case

FORMS = "avoid<=KMH, impact<=KMH, keep, pass, or one of them for some tests, such as CPNCO:avoid<=30"
_FORM = re.compile(r"(?:(?P<tests>[^:]+):)?(?P<what>avoid|impact|keep|pass)(?:<=(?P<limit>[0-9]+(?:\.[0-9]+)?))?")


class RequirementError(ValueError):
    """A requirement can't be understood, or says nothing about the tests. The message says what to do."""


@dataclass(frozen=True)
class CrashRequirement:
    """What is required of every driver."""

    text: str
    """How it was written."""
    what: str
    """``avoid``: no contact at speeds up to the limit. ``impact``: no impact faster than the limit. ``keep``: no
    braking in tests without need. ``pass``: what the tests themselves ask for."""
    limit: float | None = None
    """A speed [km/h]."""
    tests: str = ""
    """The beginning of the names of the tests that count."""

    @classmethod
    def of(cls, text: str) -> CrashRequirement:
        """Return what a text requires. Raises RequirementError for another text."""
        found = _FORM.fullmatch(text.replace(" ", ""))
        if found is None or (found["what"] in ("avoid", "impact")) != (found["limit"] is not None):
            raise RequirementError(f"--require {text}: can't be understood; write {FORMS}")
        limit = None if found["limit"] is None else float(found["limit"])
        return cls(text, found["what"], limit, found["tests"] or "")

    def shortfalls(self, outcomes: Sequence[CrashOutcome]) -> list[str]:
        """Return in words where outcomes fall short."""
        return [_in_words(x) for x in outcomes if self._is_about(x) and not self._met(x)]

    def check(self, cases: Sequence[Case]) -> None:
        """Raise RequirementError if it is about none of the runs."""
        if not any(self._is_about(case) for case in cases):
            raise RequirementError(f"--require {self.text}: no test of the suite is of that kind; check the names")

    def _is_about(self, run: Case | CrashOutcome) -> bool:
        if not run.test_name.replace(" ", "").startswith(self.tests):
            return False
        if self.what == "pass":
            return run.asks
        slow_enough = self.what != "avoid" or self.limit is None or run.speed <= self.limit
        return run.no_brake == (self.what == "keep") and slow_enough

    def _met(self, outcome: CrashOutcome) -> bool:
        if self.what == "impact":
            return outcome.result != "not met" and (outcome.impact is None or outcome.impact <= (self.limit or 0))
        return bool(outcome.passed) if self.what == "pass" else not outcome.fails


def _in_words(outcome: CrashOutcome) -> str:
    """Return an outcome in a few words."""
    name = outcome.test if outcome.variant is None else f"{outcome.test}, {outcome.variant}"
    at = f" at {outcome.impact:.0f} km/h" if outcome.impact is not None else ""
    braked = f" at {outcome.hardest:.1f} m/s2, down to {outcome.slowest:.0f} km/h" if outcome.result == "braked" else ""
    what = "hit" if outcome.impact is not None else outcome.result
    return f"{name}, {outcome.speed:g} km/h: {what}{at}{braked}"
