"""Say how often drivers hit somebody and arrive; and how late they are, where they clearly differ in that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from jaxwalk.evaluation.document_parts import Interval, Number
from jaxwalk.report.decision import Evidence
from jaxwalk.report.reversals import apart
from jaxwalk.report.table import shown


def shares(evidence: Evidence, drivers: Sequence[str], other: str = "") -> str:
    """Return how often the car hits somebody and arrives with the first driver and, in brackets, with the second one.

    ``other`` says who the second one is, as in ``the next``.
    """
    beside = [f"with {other + ', ' if other else ''}{name}" for name in drivers[1:]]
    parts = []
    for place, people in enumerate(evidence.populations):
        among = f" among {people}" if len(evidence.populations) > 1 else ""
        values = [f"{percent(evidence.hits[name, people].value)} %" for name in drivers]
        head = f"{values[0]} of scenarios with {drivers[0]}" if place == 0 else values[0]
        parts.append(f"in {head}{among}{_bracketed(values, beside)}")
    goals = [f"{percent(evidence.mean(evidence.goals, name))} %" for name in drivers]
    arrives = f"in {goals[0]}{_bracketed(goals, [f'with {name}' for name in drivers[1:]])}"
    return f"the moving car hits somebody {listed(parts)}, and it arrives {arrives}{_late(evidence, drivers)}."


def ranges(evidence: Evidence, first: str, last: str) -> str:
    """Return between what numbers all drivers lie; ``first`` has the fewest hits and ``last`` the most."""
    hits, goals = (_range(evidence, of) for of in (evidence.hits, evidence.goals))
    return f"the moving car hits somebody {hits} of scenarios, from {first} to {last}, and it arrives {goals}."


def _bracketed(values: Sequence[str], beside: Sequence[str]) -> str:
    """Return the second value with whose it is."""
    return "".join(f" ({value} {whose})" for value, whose in zip(values[1:], beside, strict=True))


def _late(evidence: Evidence, drivers: Sequence[str]) -> str:
    """Return how often two drivers run out of time, and how late they are, if their intervals lie apart."""
    if len(drivers) < 2:
        return ""
    found = ""
    if _differ(evidence, evidence.timeouts, drivers):
        times = [f"{percent(evidence.mean(evidence.timeouts, name))} %" for name in drivers]
        found += f"; it runs out of time in {times[0]}{_bracketed(times, [f'with {name}' for name in drivers[1:]])}"
    if _differ(evidence, evidence.delays, drivers):
        delays = [f"{evidence.mean(evidence.delays, name):.1f} s" for name in drivers]
        found += f"; its mean delay is {delays[0]}{_bracketed(delays, [f'with {name}' for name in drivers[1:]])}"
    return found


def _differ(evidence: Evidence, of: Mapping[tuple[str, str], Number], drivers: Sequence[str]) -> bool:
    """Return whether two drivers' intervals lie apart among some people, and never the other way round.

    Their mean over populations, which is what is said, must then exist.
    """
    unknown = Interval(None, None, None)
    cells = [[of.get((name, people), unknown) for name in drivers[:2]] for people in evidence.populations]
    states = {apart(a, b) for a, b in cells} - {"open"}
    return len(states) == 1 and all(one.value is not None for cell in cells for one in cell)


def _range(evidence: Evidence, of: Mapping[tuple[str, str], Number]) -> str:
    """Return the lowest and the highest share of all drivers."""
    found = [evidence.mean(of, driver) for driver in evidence.drivers]
    known = [value for value in found if value is not None]
    return f"in {percent(min(known))} to {percent(max(known))} %" if known else "in an unknown share"


def percent(share: float | None) -> str:
    """Return a share in per cent, with as many digits as in tables."""
    return shown(Interval(share, None, None))


def listed(parts: Sequence[str]) -> str:
    """Return parts as in ``a, b and c``."""
    return " and ".join([", ".join(parts[:-1]), parts[-1]]) if len(parts) > 1 else parts[0]
