"""Say a decision in three sentences: who is safer and by how much, how sure that is, and what it rests on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from jaxwalk.metrics import FEWEST_SEEDS, SURE, scenarios_needed
from jaxwalk.report.decision import Decision, Duel, Evidence
from jaxwalk.report.shares import listed, percent, ranges, shares
from jaxwalk.report.table import UNJUDGED
from jaxwalk.wording import MOST_NAMED, counted, first_of


@dataclass(frozen=True)
class Sentences:
    """The verdict of a report in three sentences."""

    headline: str
    """Who is safer: the beginning of the first sentence ..."""
    numbers: str
    """... and by how much: the rest of it."""
    sure: str
    """How sure that is."""
    rests: str
    """What it rests on."""

    @property
    def who(self) -> str:
        """The first sentence."""
        return f"{self.headline}: {self.numbers}"


@dataclass(frozen=True)
class Driven:
    """How much was driven, in all cells together."""

    scenarios: int
    """Scenarios for each driver and population."""
    seed: int | None
    kilometres: float
    encounters: int
    people: int | None
    """Pedestrians in each scenario; None if the results don't say."""
    streets: tuple[str, ...]
    """Names of the streets; empty if the results don't say."""


def say(evidence: Evidence, decision: Decision, driven: Driven) -> Sentences:
    """Return the three sentences."""
    headline, numbers = _who(evidence, decision)
    return Sentences(headline, numbers, _sure(evidence, decision), _rests(evidence, driven))


def _who(evidence: Evidence, decision: Decision) -> tuple[str, str]:
    """Return who is safer, and by how much."""
    leader, count = decision.leader, len(decision.order)
    if decision.kind == "alone":
        return f"Who is safer {UNJUDGED}, because {leader} alone was evaluated", shares(evidence, [leader])
    if count == 2:
        other = next(name for name in decision.order if name != leader)
        return _of_two(evidence, decision, other), shares(evidence, [leader, other])
    if decision.kind == "safest":
        numbers = shares(evidence, [leader, decision.beaten[0]], "the next")
        return f"{leader} is the safest of {count} drivers{_among(evidence, decision)}", numbers
    if decision.kind == "ahead":
        return _ahead(evidence, decision), shares(evidence, [leader, decision.tied[0]])
    headline = {
        "even": f"No difference in safety is shown between the {count} drivers",
        "depends": f"Which of the {count} drivers is the safest depends on the people that they meet",
    }.get(decision.kind, f"Which of the {count} drivers is the safest {UNJUDGED}")
    return headline, ranges(evidence, decision.order[0], decision.order[-1])


def _of_two(evidence: Evidence, decision: Decision, other: str) -> str:
    a, b = decision.leader, other
    if decision.kind == "safest":
        return f"{a} is safer than {b}{_among(evidence, decision)}"
    if decision.kind == "depends":
        among = " and ".join(f"{duel.safer} among {duel.people}" for duel in decision.between(a, b) if duel.safer)
        return f"Which of {a} and {b} is safer depends on the people that they meet, {among}"
    if decision.kind == "even":
        return f"No difference in safety is shown between {a} and {b}"
    return f"Which of {a} and {b} is safer {UNJUDGED}"


def _among(evidence: Evidence, decision: Decision) -> str:
    """Return among which people the leader is surely safer than all others that it beats, if not among all."""
    wins = [{duel.people for duel in decision.between(decision.leader, name) if duel.safer} for name in decision.beaten]
    sure = [people for people in evidence.populations if all(people in won for won in wins)]
    if len(sure) == len(evidence.populations):
        return ""
    return f" among {' and '.join(sure)}" if sure else ", beside each among some of the people only"


def _ahead(evidence: Evidence, decision: Decision) -> str:
    leader, tied = decision.leader, decision.tied
    judged = any(duel.judged for name in tied for duel in decision.between(leader, name))
    beaten, others = decision.beaten, len(decision.order) - 1
    than = listed(beaten) if len(beaten) <= MOST_NAMED else f"{len(beaten)} of the {others} other drivers"
    rest = listed(tied) if len(tied) <= MOST_NAMED else counted(len(tied), "other")
    among = _among(evidence, decision)
    return f"{leader} is safer than {than}{among}; whether also than {rest} {'is not shown' if judged else UNJUDGED}"


def _sure(evidence: Evidence, decision: Decision) -> str:
    """Return how sure the verdict is."""
    if decision.kind == "alone":
        return _sure_alone(evidence, decision.leader)
    if decision.kind == "uncompared":
        return "Nothing can be said: these results compare no drivers, as those of an older version; evaluate again."
    if decision.kind == "unjudged":
        return _too_few(evidence, decision.duels)
    if decision.kind in ("safest", "ahead"):
        return _sure_of(evidence, decision)
    other = decision.tied[0] if len(decision.order) == 2 else decision.order[-1]
    if other == decision.leader:
        other = decision.order[0]
    duels = decision.between(decision.leader, other)
    said = listed([_difference(duel, decision.leader) for duel in duels])
    if decision.kind == "depends":
        return f"The differences point to both sides: {said}."
    return f"{_begun(said)}{_needed(duels)}."


def _sure_alone(evidence: Evidence, driver: str) -> str:
    found = [(people, evidence.hits[driver, people]) for people in evidence.populations]
    known = [(people, one) for people, one in found if one.low is not None and one.high is not None]
    if not known:
        return f"There is no interval for its share of hits; {COMPARE}."
    ends = listed([f"{percent(one.low)} and {percent(one.high)} % among {people}" for people, one in known])
    return f"On other scenarios of this kind its share of hits lies between {ends} (95 % intervals); {COMPARE}."


COMPARE = "to judge it, name a second driver beside it, such as clearance"


def _sure_of(evidence: Evidence, decision: Decision) -> str:
    """Return how sure it is that the leader is safer than the next driver, and than the others."""
    leader, following = decision.leader, decision.beaten[0]
    sure = [duel for duel in decision.between(leader, following) if duel.safer]
    said = listed([_difference(duel, leader) for duel in sure])
    largest = max(
        min(duel.p for duel in decision.between(leader, name) if duel.safer and duel.p is not None)
        for name in decision.beaten
    )
    tests = decision.duels[0].tests
    corrected = f", corrected for {counted(tests, 'comparison')}" if tests > 1 else ""
    elsewhere = "; among the others no difference is shown" if len(sure) < len(evidence.populations) else ""
    return f"{_begun(said)}{elsewhere}; {_chance(largest)}{corrected}{_unjudged(decision)}."


def _unjudged(decision: Decision) -> str:
    """Return why some drivers can't be judged beside the leader, if that is so."""
    found = {name: decision.between(decision.leader, name) for name in decision.tied}
    names = [name for name, duels in found.items() if not any(duel.judged for duel in duels)]
    if not names:
        return ""
    few_seeds = any(duel.p is None for name in names for duel in found[name])
    missing = f"training seeds (it takes {FEWEST_SEEDS})" if few_seeds else "hits (evaluate more scenarios: --episodes)"
    return f"; beside {listed(names)} there are too few {missing}"


def _chance(p: float) -> str:
    """Return what a p-value means."""
    if p < 0.001:
        return (
            "if they were equally safe, chance would show so large a difference less than once in 1,000 such tests "
            "(p < 0.001)"
        )
    return (
        f"if they were equally safe, chance would show so large a difference about once in {round(1 / p):,} such "
        f"tests (p = {p:.3f})"
    )


def _difference(duel: Duel, leader: str) -> str:
    """Return the difference of a comparison, seen from the leader."""
    found = duel.found
    low, value, high = found.difference.low, found.difference.value, found.difference.high
    other = found.b.driver
    if found.b.driver == leader:
        low, value, high, other = _minus(high), _minus(value), _minus(low), found.a.driver
    more = "more" if value is None or value >= 0 else "fewer"
    if more == "fewer":
        low, value, high = _minus(high), _minus(value), _minus(low)
    points = "unknown" if value is None else f"{100 * value:.2f}"
    ends = "" if low is None or high is None else f" (95 % interval {100 * low:.2f} to {100 * high:.2f})"
    return f"among {duel.people} {other} hits somebody in {points} points {more} of the scenarios than {leader}{ends}"


def _minus(value: float | None) -> float | None:
    return None if value is None else 0.0 - value


def _needed(duels: Sequence[Duel]) -> str:
    """Return how many scenarios it would take to tell rates like these apart, if policies are compared."""
    first = duels[0].found
    rates = first.a.rate, first.b.rate
    if first.training_seeds > 1 or rates[0] == rates[1]:
        return ""
    try:
        needed = scenarios_needed(*rates, both=first.both / max(first.pairs, 1), alpha=SURE / max(duels[0].tests, 1))
    except ValueError:  # a damaged document's counts contradict its rates
        return ""
    return (
        f"; to tell shares that far apart from chance takes some {float(f'{needed:.1e}'):,.0f} scenarios (--episodes)"
    )


def _too_few(evidence: Evidence, duels: Sequence[Duel]) -> str:
    """Return what is missing."""
    if any(duel.p is None for duel in duels):
        return (
            f"{counted(evidence.seeds, 'training seed')} are too few: they don't tell how much trainings differ, and "
            f"a sentence about training takes {FEWEST_SEEDS} (--seeds {FEWEST_SEEDS})."
        )
    hits, pairs = max(duel.hits for duel in duels), max(duel.found.pairs for duel in duels)
    return (
        f"Not at all: two drivers together hit somebody at most {counted(hits, 'time')} in "
        f"{counted(pairs, 'scenario')}, too seldom for any test; evaluate more scenarios (--episodes)."
    )


def _rests(evidence: Evidence, driven: Driven) -> str:
    """Return what the verdict rests on."""
    seed = "" if driven.seed is None else f" of seed {driven.seed}"
    people = "" if driven.people is None else f" with {counted(driven.people, 'pedestrian')} each"
    streets = f" on {first_of(driven.streets, 'street')}" if driven.streets else ""
    names, training = evidence.populations, _training(evidence)
    among = f"{names[0]} people" if len(names) == 1 else f"{counted(len(names), 'population')} ({', '.join(names)})"
    many = len(evidence.drivers) > 1
    return (
        f"It rests on {counted(driven.scenarios, 'simulated scenario')}{seed}{people}{streets}"
        f"{', the same for every driver' if many else ''}, among {among}: {driven.kilometres:,.0f} km and "
        f"{counted(driven.encounters, 'encounter')} in all{'; ' if training else ''}{training}."
    )


def _training(evidence: Evidence) -> str:
    """Return how far the verdict reaches beyond these policies; empty if nothing was trained."""
    return {
        "none": "",
        "unknown": (
            "it isn't known whether a Python driver was trained: one that was may turn out otherwise when trained again"
        ),
        "one": "it is about these very policies: one that was trained may turn out otherwise when trained again",
        "few": f"{counted(evidence.seeds, 'training seed')} are too few for a sentence about training",
        "enough": f"{evidence.seeds} training seeds stand behind it, so it is about training such drivers again",
    }[evidence.training]


def _begun(said: str) -> str:
    """Return words as the beginning of a sentence."""
    return said[0].upper() + said[1:]
