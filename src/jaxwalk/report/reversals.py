"""What the paper found, and which of it reverses here: one sentence about all of its comparisons."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from jaxwalk.evaluation.document_parts import Number
from jaxwalk.metrics import ATTRIBUTION, ENCOUNTERS, SPEED_DIFFERENTIAL
from jaxwalk.report import published
from jaxwalk.report.material import ALWAYS_GO, CO_TRAINED, SINGLE_AGENT, Material
from jaxwalk.wording import counted

State = Literal["holds", "reverses", "open"]


@dataclass(frozen=True)
class Claim:
    """A direction that the paper reports."""

    paper: str
    """What it found, as in ``training together makes the car collide less``."""
    opposite: str
    """What the reverse is, as in ``more``."""
    state: State
    """Whether ours, by its 95 % interval, has the same direction, the opposite one, or neither."""


def sentence(claims: Sequence[Claim]) -> str:
    """Say which of the claims reverse, which hold and which are open; empty without claims."""
    if not claims:
        return ""
    groups: dict[State, list[str]] = {"reverses": [], "holds": [], "open": []}
    for claim in claims:
        groups[claim.state].append(claim.paper + (f" (here {claim.opposite})" if claim.state == "reverses" else ""))
    verbs = {"reverses": ("reverses", "reverse"), "holds": ("holds", "hold"), "open": ("is open", "are open")}
    parts = [
        f"{len(found)} {verbs[name][len(found) > 1]}: {', '.join(found)}" for name, found in groups.items() if found
    ]
    none = "" if groups["reverses"] else "none reverses; "
    return f"Of {counted(len(claims), 'direction')} that the paper reports, {none}{'; '.join(parts)}."


def state(number: Number, nothing: float, *, sign: int) -> State:
    """Return whether a number lies on the paper's side of what means no difference, by its interval.

    ``sign`` is 1 if the paper's number is above ``nothing``, and -1 if it is below.
    """
    low, high = number.low, number.high
    above, below = low is not None and low > nothing, high is not None and high < nothing
    if not above and not below:
        return "open"
    return "holds" if above == (sign > 0) else "reverses"


def apart(first: Number, second: Number) -> State:
    """Return whether the second number is above the first one (holds) or below it (reverses), by their intervals."""
    if first.low is None or first.high is None or second.low is None or second.high is None:
        return "open"
    if second.low > first.high:
        return "holds"
    return "reverses" if second.high < first.low else "open"


def claims(material: Material) -> tuple[Claim, ...]:
    """Return the paper's claims beside ours; none unless the report repeats its experiment."""
    return tuple(_claims(material)) if material.trainings is not None else ()


def _claims(material: Material) -> Iterator[Claim]:
    yield from _together(material)
    cell = material.cell(material.subject, material.crowd)
    gap = cell.summary[SPEED_DIFFERENTIAL][0].pooled.difference
    yield Claim("the car is faster near jaywalkers than near crosswalk users", "slower", state(gap, 0.0, sign=1))
    risk = cell.summary[ATTRIBUTION].per_crossing.ratio
    yield Claim(
        "a jaywalk ends in a collision more often than a crossing on a crosswalk",
        "less often",
        state(risk, 1.0, sign=1),
    )
    met = cell.summary[ENCOUNTERS]
    nearer = apart(met.jaywalk.minimum_approach, met.crosswalk.minimum_approach)
    yield Claim("the car comes nearer to jaywalkers than to crosswalk users", "less near", nearer)
    yield from _more_jaywalking(material)


def _together(material: Material) -> Iterator[Claim]:
    """Yield what training together does to collisions, if that was compared."""
    for found in material.results.paired:
        sides = [(side.driver, side.pedestrians) for side in (found.a, found.b)]
        if found.ending == "collision" and sides == [(SINGLE_AGENT, ALWAYS_GO), (CO_TRAINED, ALWAYS_GO)]:
            yield Claim(
                "a car trained together with its people collides less", "more", state(found.difference, 0.0, sign=-1)
            )


def _more_jaywalking(material: Material) -> Iterator[Claim]:
    """Yield what more jaywalking does to collisions, if that was evaluated."""
    ends = [m for m in (min(published.ABLATION), max(published.ABLATION)) if m in material.multipliers]
    if len(ends) == 2 and ALWAYS_GO in material.ablated_populations:
        few, many = (material.ablated(multiplier, ALWAYS_GO).collision_rate.mean for multiplier in ends)
        yield Claim("more jaywalking means more collisions", "fewer", apart(few, many))
