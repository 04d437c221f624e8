"""Write the results of `jaxwalk generalisation` as a Markdown page, which begins with an answer in words."""

from __future__ import annotations

from collections.abc import Sequence

from jaxwalk.evaluation.document_parts import Interval
from jaxwalk.evaluation.over_streets import Counted, StreetScores, StreetSet, gap, share
from jaxwalk.metrics import FEWEST_SEEDS
from jaxwalk.provenance import Provenance
from jaxwalk.report.table import NONE, Table, shown
from jaxwalk.wording import counted

OWN, TEST = "own", "test"
"""Names of the sets of streets: each trained car's own ones, and unseen ones of the same family."""
USUAL = 12
"""People on all sets but for the table of densities."""
TITLES: dict[Counted, str] = {"goal": "Goals [%]", "touched": "Touched by the moving car [%]"}
"""What the tables show."""

ABOUT = (
    "`streets-N` is the car of recipe `town`, trained alone on N streets; cars of other training seeds have other "
    "streets. `own` are the streets that a car was trained on, `test` unseen streets of the same family, "
    "`unseen-ranges` streets whose parameters lie outside all that training had, `paper` the paper's street in the "
    "world `town`. Everybody drives among people who always go, on the same scenarios. The blind `route-follower`, the "
    "rule `clearance` and the `oracle`, which knows the future, show how hard the streets are. Touched: episodes in "
    "which the moving car touched somebody by its footprint."
)
BRACKETS = (
    "Brackets are 95 % intervals, with streets as units: of trained cars for other training seeds and other streets "
    f"(none with fewer than {FEWEST_SEEDS} seeds), of rules for other streets (none on a single street)."
)


def page(sets: Sequence[StreetSet], *, updates: int, made: Provenance) -> str:
    """Return the answer and all tables; ``updates`` are those of each training."""
    seeds = sorted({one.training_seed for found in sets for one in found.scores if one.training_seed is not None})
    parts = [
        "# Does the car cope with streets that it has never seen?",
        answer(sets),
        ABOUT,
        f"Training seeds: {', '.join(map(str, seeds))}; {counted(updates, 'update')} each; commit "
        f"{made.commit or 'unknown'}, {made.hardware}. {BRACKETS}",
        *(f"- `{found.name}`: {counted(len(found.streets), 'street')}" for found in sets if _is_usual_test(found)),
    ]
    for what, title in TITLES.items():
        parts += [f"## {title}", f"Among {USUAL} people:", _streets(sets, what).markdown()]
        parts += ["On `test`, by the number of people:", _crowds(sets, what).markdown()]
    return "\n\n".join(parts) + "\n"


def answer(sets: Sequence[StreetSet]) -> str:
    """Return, for each number of streets, how far goals fall on unseen streets."""
    at_home, tested = _own(sets), _test(sets)
    sentences = []
    for driver, own in at_home.items():
        away, difference = tested[driver], gap(own, tested[driver], "goal")
        judged = "" if difference.low is not None else ", with no interval"
        sentences.append(
            f"`{driver}` reaches its goal in {shown(_mean(own, 'goal'))} % on its own streets and in "
            f"{shown(share(away, 'goal'))} % on unseen ones: a gap of {shown(difference, digits=2)} points{judged}."
        )
    return " ".join(sentences)


def _streets(sets: Sequence[StreetSet], what: Counted) -> Table:
    """Return the table of sets of streets, with the difference of the first two."""
    at_home, tests = _own(sets), [found for found in sets if _is_usual_test(found)]
    tested = _test(sets)
    rows = []
    for driver in tested:
        own = at_home.get(driver)
        home, less = (NONE, NONE)
        if own:
            home, less = shown(_mean(own, what), digits=2), shown(gap(own, tested[driver], what), digits=2)
        rows.append((driver, home, *(_cell(found, driver, what) for found in tests), less))
    return Table(("driver", OWN, *(found.name for found in tests), f"{OWN} minus {TEST}"), tuple(rows))


def _crowds(sets: Sequence[StreetSet], what: Counted) -> Table:
    """Return the table of numbers of people on the test's streets."""
    tests = [found for found in sets if found.name == TEST]
    rows = [(driver, *(_cell(found, driver, what) for found in tests)) for driver in _test(sets)]
    return Table(("driver", *(str(found.people) for found in tests)), tuple(rows))


def _cell(found: StreetSet, driver: str, what: Counted) -> str:
    return shown(share(_by_driver(found.scores)[driver], what), digits=2)


def _mean(own: Sequence[StreetScores], what: Counted) -> Interval:
    """Return the mean over training seeds, each on its own streets; it has no interval of its own."""
    each = [sum(getattr(one, what)) / sum(one.episodes) for one in own]
    return Interval(sum(each) / len(each), None, None)


def _own(sets: Sequence[StreetSet]) -> dict[str, list[StreetScores]]:
    """Return the scores of each trained car on its own streets, one for each training seed."""
    return _by_driver([one for found in sets if found.name == OWN for one in found.scores])


def _test(sets: Sequence[StreetSet]) -> dict[str, list[StreetScores]]:
    """Return everybody's scores on the test's streets, among the usual number of people."""
    return _by_driver(next(found.scores for found in sets if (found.name, found.people) == (TEST, USUAL)))


def _by_driver(scores: Sequence[StreetScores]) -> dict[str, list[StreetScores]]:
    found: dict[str, list[StreetScores]] = {}
    for one in scores:
        found.setdefault(one.driver, []).append(one)
    return found


def _is_usual_test(found: StreetSet) -> bool:
    return found.name != OWN and found.people == USUAL
