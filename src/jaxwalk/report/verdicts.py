"""One sentence for each comparison: is the paper's number in our interval, and if not, why might that be?"""

from __future__ import annotations

from dataclasses import dataclass

from jaxwalk.evaluation.document_parts import Number
from jaxwalk.wording import counted


@dataclass(frozen=True)
class Versus:
    """One of our numbers next to the paper's."""

    what: str
    """Name of the quantity."""
    ours: Number
    theirs: float
    unit: str = "%"
    scale: float = 100.0
    """Factor that converts our number to the unit."""

    @property
    def known(self) -> tuple[float, float, float] | None:
        """Return our value and its interval in the unit; None unless all three exist."""
        value, low, high = self.ours.value, self.ours.low, self.ours.high
        if value is None or low is None or high is None:
            return None
        return self.scale * value, self.scale * low, self.scale * high

    @property
    def agrees(self) -> bool:
        """Return whether the paper's number lies in our interval."""
        return self.known is not None and self.known[1] <= self.theirs <= self.known[2]


def verdict(comparisons: list[Versus], reason: str) -> str:
    """Say where the paper's numbers lie outside our intervals, and why; or that they lie inside."""
    unknown = [c for c in comparisons if not c.known]
    differing = [_gap(c, c.known[0]) for c in comparisons if c.known and not c.agrees]
    agreeing = [c for c in comparisons if c.agrees]
    parts = []
    if differing:
        parts.append(f"Differs from the paper: {_list(differing)}. {reason}")
    if agreeing:
        every = not differing and not unknown
        names = "every number" if every and len(agreeing) > 1 else _list([c.what for c in agreeing])
        parts.append(f"The paper's value lies in our 95 % interval for {names}.")
    if unknown:
        parts.append(f"Too few cases to say: {_list([c.what for c in unknown])}.")
    return " ".join(parts)


def brief(comparisons: list[Versus]) -> str:
    """Say in a few words how ours compare with the paper's; empty if nothing can be compared."""
    known = [c for c in comparisons if c.known]
    differing = sum(not c.agrees for c in known)
    if not known:
        return ""
    if not differing:
        return f"Agrees with the paper in {counted(len(known), 'number')}."
    return f"Differs from the paper in {differing} of {counted(len(known), 'number')}."


def _gap(c: Versus, value: float) -> str:
    word = "above" if value > c.theirs else "below"
    return f"{c.what}: {number(value)}, {word} {number(c.theirs)} {c.unit}".rstrip()


def _list(items: list[str]) -> str:
    separator = "; " if any("," in item for item in items) else ", "
    return separator.join(items)


def number(value: float) -> str:
    """Return the number with as many digits as the paper gives."""
    return f"{value:.1f}" if abs(value) >= 10 else f"{value:.2f}"


COLLISION = "The paper's collisions are centres closer than 1.5 m; the top of this page says what counts here."
WORLD = (
    "Ours is another world in its details: crosswalks that all join two kerbs, a jaywalk decided once per crossing and "
    "kept (the published code draws again every 0.1 s), nobody starting within 10 m of the car, routes along lanes. "
    f"{COLLISION}"
)
BASELINES = (
    f"{WORLD} The paper does not say among which people its rules drove, nor their throttle, cone or braking; ours "
    "are listed (docs: evaluation)."
)
TRAINED = (
    "Our drivers were trained with the recipe named above, not the paper's: they see their route rather than the goal "
    "as the crow flies, timeouts bootstrap instead of counting as failures, each role has its own critic, and the "
    f"reward is for progress along the lane. World and people differ in details too. {COLLISION} We have not separated "
    "these causes."
)
SPEED = (
    "The figure depends on how the driver was trained and on who is nearest: ours sees predicted clearances and "
    "slows for anybody in its way, so a difference near jaywalkers is smaller where they are seen in time. Frames of "
    "one long, slow encounter dominate the pooled figure; the one by encounter weighs each meeting alike."
)
ATTRIBUTION = (
    "Our jaywalks are committed: a jaywalker walks straight across at one speed, and can be predicted once on the "
    "road; the published code draws anew at every step. Of crossings begun, a smaller share are jaywalks than of "
    "decisions (there, equation 1 holds): a jaywalker first walks to its point, and some episodes end before. The "
    "share of collisions also depends on how well the driver deals with crosswalks."
)
APPROACH = (
    "Not comparable in the strict sense: the paper does not define its encounter. Ours begins with the car within 20 "
    "m and closing, includes collisions, and lasts until the pedestrian leaves the road."
)
BRAKING = (
    "Ours begins at the first braking command of 1 m/s² or more held for 0.3 s after road entry, and counts a car that "
    "was braking already, or never brakes, apart (the median accounts for the latter); the paper defines none "
    "of these."
)
ABLATION = f"{TRAINED} As in the paper the driver is evaluated, not retrained."
QUARTERS = "The rate is multiplier x trait by construction, so a difference would be a fault, or chance in one of 20."
