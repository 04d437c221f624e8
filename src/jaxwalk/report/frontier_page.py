"""Write the results of `jaxwalk frontier` as a Markdown page, which begins with who is dominated, in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from jaxwalk.evaluation.document_parts import PolicyOrigin
from jaxwalk.evaluation.frontier_scores import FrontierScores, FrontierSuite, Rivalry, Standing, standings
from jaxwalk.metrics import proportion
from jaxwalk.policies.knobs import KNOBS
from jaxwalk.provenance import Provenance
from jaxwalk.report.figures.frontier import LEAST
from jaxwalk.report.table import NONE, Table, shown
from jaxwalk.wording import counted, first_of

ABOUT = (
    "Contacts are scenarios in which the moving car touches somebody, by its footprint; delay is the time beyond "
    "untouchable full throttle on the same scenario, over scenarios in which the car arrives. A driver is *dominated* "
    "if another one has fewer contacts and less delay on the same scenarios (delay: on those in which both arrive), by "
    "intervals that exclude 0 and hold for all rivals of the driver together with 95 % (Bonferroni). It is *not "
    "dominated* if each of the others has more contacts or more delay, by such an interval. Else it *cannot be "
    "judged* on so few scenarios. Drivers that see what no real car can are shown, and are nobody's rivals."
)
BRACKETS = (
    "Brackets: 95 % intervals over scenarios on these streets, each for itself. In the plots a line is a driver and a "
    f"sign a setting or a shield, filled if it is not dominated; contacts below {LEAST:g} % are drawn there. Delay "
    "leaves out who doesn't arrive: see goals and timeouts beside it."
)


def frontier_page(
    suites: Sequence[FrontierSuite], *, seed: int, origins: Sequence[PolicyOrigin], made: Provenance
) -> str:
    """Return the answer in words for each suite, its plot and its table."""
    first = suites[0]
    parts = [
        "# Contacts against delay",
        *(answer(found) for found in suites),
        ABOUT,
        f"{counted(first.scores[0].scenarios, 'scenario')} of seed {seed} in each suite, among {first.pedestrians}; "
        f"commit {made.commit or 'unknown'}, {made.hardware}. {BRACKETS}",
        f"Drivers: {', '.join(origin.in_words() for origin in origins)}.",
    ]
    unturned = {scores.contender.name for scores in first.scores}
    knobs = [origin.name for origin in origins if origin.name in KNOBS and origin.name not in unturned]
    if knobs:
        parts += ["## The knobs", _knobs(knobs).markdown()]
    for found in suites:
        parts += [
            f"## {found.suite}",
            f"Hash of the scenarios: {found.scenario_hash}.",
            f"![Contacts against delay in {found.suite}](frontier-{found.suite}.svg)",
            _table(found).markdown(),
        ]
    return "\n\n".join(parts) + "\n"


def answer(found: FrontierSuite) -> str:
    """Return in words who is dominated by which rival in a suite, and of which of them that is open."""
    pairs = list(zip(found.scores, standings(found.scores), strict=True))
    best = _names(pairs, "not dominated")
    is_open = _names(pairs, "cannot be judged")
    first = (
        f"**{found.suite}.** Not dominated: {', '.join(best) or 'nobody for certain'}. "
        f"Cannot be judged: {', '.join(is_open) or 'nobody'}."
    )
    beaten = (
        f"- {one.contender.name} is dominated by {_by_rival(standing)}."
        for one, standing in pairs
        if standing.beaten_by
    )
    return "\n".join((first, "", *beaten)).rstrip()


def _names(pairs: Sequence[tuple[FrontierScores, Standing]], verdict: str) -> list[str]:
    return [one.contender.name for one, standing in pairs if standing.verdict == verdict]


def _by_rival(standing: Standing) -> str:
    """Return the rival with the fewest contacts, by how much it is better, and how many others are."""
    first, *others = standing.beaten_by
    more = f", and by {counted(len(others), 'other')}" if others else ""
    return f"{first.rival} ({_better(first)}){more}"


def _better(found: Rivalry) -> str:
    """Return both differences with their intervals."""
    return f"{shown(found.contacts, digits=2)} points of contacts, {shown(found.delay, 1.0, 2)} s"


def _table(found: FrontierSuite) -> Table:
    """Return the table of a suite."""
    columns = ("driver", "contacts %", "delay [s]", "goals %", "timeouts %", "verdict")
    return Table(columns, tuple(_rows(found)))


def _rows(found: FrontierSuite) -> Iterator[tuple[str, ...]]:
    for one, standing in zip(found.scores, standings(found.scores), strict=True):
        ended = (shown(proportion(count, one.scenarios)) for count in (one.goals, one.timeouts))
        rates = (shown(one.contact_rate()), shown(one.mean_delay(), 1.0, 2))
        yield one.contender.name, *rates, *ended, _verdict(standing)


def _verdict(standing: Standing) -> str:
    """Return the verdict, and the rivals against which it is open or lost."""
    if standing.beaten_by:
        return f"dominated by {first_of([rival.rival for rival in standing.beaten_by], 'driver')}"
    if standing.open_against:
        return f"{standing.verdict} against {first_of(standing.open_against, 'driver')}"
    return NONE if standing.verdict == "no real car" else standing.verdict


def _knobs(names: Sequence[str]) -> Table:
    """Return what is turned of each driver."""
    rows = []
    for name in names:
        knob = KNOBS[name]
        settings = ", ".join(knob.shown(x) for x in knob.settings)
        rows.append((name, knob.what, f"{settings} {knob.unit}".rstrip(), knob.shown(knob.usual)))
    return Table(("driver", "knob", "settings", "its own"), tuple(rows))
