"""Write the results of `jaxwalk co-training` as a Markdown page, which begins with an answer in words."""

from __future__ import annotations

from collections.abc import Sequence

from jaxwalk.evaluation.document_parts import PairedSeeds, SeedNumbers
from jaxwalk.evaluation.results import Results
from jaxwalk.evaluation.training_seeds import Ending
from jaxwalk.metrics import FEWEST_SEEDS, SURE, holm
from jaxwalk.report.material import ALWAYS_GO, CLEARANCE
from jaxwalk.report.seed_tables import delay_table, paired_table
from jaxwalk.report.table import MOVING, Table, shown
from jaxwalk.wording import counted

ALONE, PURE, MIXED, STAND_INS = "alone", "pure", "mixed", "-stand-ins"
"""The trainings: a co-trained one is named pure or mixed, and with ``STAND_INS`` if people met careless cars."""
PEOPLE = {f"people of {name}": name for name in (PURE, PURE + STAND_INS)}
"""The learned populations, and the training from which they come."""
FACTORS = (
    (PURE, MIXED), (PURE + STAND_INS, MIXED + STAND_INS), (PURE, PURE + STAND_INS), (MIXED, MIXED + STAND_INS),
)  # fmt: skip
"""Pairs of trainings that differ in one treatment."""
TOUCHED: Ending = "moving contact"
"""What the answer is about."""

ABOUT = (
    "`alone`: the car learns among people who always go. In the other four trainings people learn too. `pure`: "
    "everybody that the car meets learns; `mixed`: in some of the car's environments people always go. `-stand-ins`: "
    "in further environments people also meet careless cars and earlier versions of the car. The car learns from "
    "equally many environments in all five. Everybody is judged where a contact with the car's footprint is a "
    "collision. A car of one training seed meets learned people of the next one, never those who learned beside it. "
    "`clearance` is a rule."
)
TABLES = (
    "Touched: episodes in which the moving car touched somebody by its footprint. Delay: seconds beyond untouchable "
    "full throttle on the same scenario, where the car arrives. People wait: approaches to the kerb with a dangerous "
    "moment in which the person waits through the first one."
)


def page(results: Results, *, updates: int) -> str:
    """Return the answer and all tables; ``updates`` are those of each training."""
    chosen, made = results.scenarios, results.made
    seeds = _seeds(results)
    origin = "" if made is None else f"; commit {made.commit or 'unknown'}, {made.hardware}"
    parts = [
        "# Does training together make a better car?",
        answer(results),
        ABOUT,
        f"Training seeds: {', '.join(map(str, seeds))}; {counted(updates, 'update')} each. {chosen.name}, hash "
        f"{chosen.hash}{origin}. Brackets are 95 % intervals over training seeds and scenarios.",
        TABLES,
    ]
    for people in _populations(results):
        parts += [f"## Among {people}", _drivers(results, people).markdown()]
    against, factors = ([x for x in results.paired if (x.a.driver == ALONE) == alone] for alone in (True, False))
    parts += [
        "## Against the car alone",
        paired_table(against).markdown(),
        delay_table(results.paired_delays).markdown(),
    ]
    parts += ["## One treatment at a time", paired_table(factors).markdown()]
    return "\n\n".join(parts) + "\n"


def answer(results: Results) -> str:
    """Return whether co-training helps, when, and why not, as far as the numbers tell."""
    tests = [x for x in results.paired if (x.a.driver, x.ending) == (ALONE, TOUCHED)]
    if any(found.p is None for found in tests):
        seeds = counted(len(_seeds(results)), "training seed")
        return (
            f"**Whether co-training makes a better car cannot be judged**: there are {seeds}, and a sentence about "
            f"training takes {FEWEST_SEEDS}."
        )
    adjusted = holm([found.p for found in tests if found.p is not None])
    sure = [found for found, p in zip(tests, adjusted, strict=True) if p < SURE]
    better = sum(found.b.rate < found.a.rate for found in sure)
    when = [_among(people, tests, sure) for people in _populations(results)]
    return " ".join([_verdict(better, len(sure) - better, len(tests)), *when, _price(results), *_why(results)])


def _verdict(better: int, worse: int, tests: int) -> str:
    """Return the answer in a sentence, from the number of comparisons with fewer and with more contacts."""
    of = f"of {tests} comparisons, by contacts of the moving car"
    if better and worse:
        return f"**Co-training makes the car better in {better} and worse in {worse}** {of}."
    if better or worse:
        side = "better" if better else "worse"
        return f"**Co-training makes the car {side} in {better or worse}** {of}; in no other is a difference shown."
    return f"**No effect of co-training is shown** in any {of}."


def _among(people: str, tests: Sequence[PairedSeeds], sure: Sequence[PairedSeeds]) -> str:
    """Return what is known among one population, against the car alone."""
    here = [found for found in tests if found.a.pedestrians == people]
    known = [f"`{x.b.driver}` {'fewer' if x.b.rate < x.a.rate else 'more'}" for x in here if x in sure]
    rest = [found for found in here if found not in sure]
    lows = [found.difference.low for found in rest if found.difference.low is not None]
    highs = [found.difference.high for found in rest if found.difference.high is not None]
    said = [f"{', '.join(known)} than the car alone"] if known else []
    if rest:
        names = ", ".join(f"`{found.b.driver}`" for found in rest)
        said.append(
            f"{names} cannot be told from it (intervals within {100 * min(lows):.2f} to {100 * max(highs):.2f} points)"
        )
    return f"Among {people}: {'; '.join(said)}."


def _price(results: Results) -> str:
    """Return the delays of the co-trained cars beside that of the car alone."""
    found = {x.driver: x.mean_delay.mean for x in results.over_seeds if x.pedestrians == ALWAYS_GO}
    values = [delay.value for name, delay in found.items() if name not in (ALONE, CLEARANCE)]
    known = [value for value in values if value is not None]
    between = f"{min(known):.2f} to {max(known):.2f} s" if known else "unknown"
    alone, rule = (shown(found[name], 1.0, 2) for name in (ALONE, CLEARANCE))
    return (
        f"Their mean delay among {ALWAYS_GO} is {between}, that of the car alone {alone} s, of the clearance rule "
        f"{rule} s."
    )


def _why(results: Results) -> list[str]:
    """Return what was left to gain, and whether there was anybody to learn from."""
    touched = (_numbers(results, name, ALWAYS_GO).moving_contact_rate.mean for name in (ALONE, CLEARANCE))
    alone, rule = (shown(share, digits=2) for share in touched)
    waits = [f"{shown(_numbers(results, ALONE, people).waited_share.mean)} % ({people})" for people in PEOPLE]
    return [
        f"What could be gained among {ALWAYS_GO}: the car alone touches somebody in {alone} % of scenarios, the "
        f"clearance rule in {rule} %.",
        f"What is there to learn from: of people that the car alone puts in danger at the kerb, {' and '.join(waits)} "
        "wait. To the car, people who do not wait are people who always go.",
    ]


def _drivers(results: Results, people: str) -> Table:
    columns = ("driver", MOVING, "of each seed", "goal %", "delay [s]", "people wait %")
    rows = []
    for found in (x for x in results.over_seeds if x.pedestrians == people):
        touched = found.moving_contact_rate
        each = ", ".join(f"{100 * value:.2f}" for value in touched.each if value is not None)
        rates = shown(touched.mean, digits=2), each, shown(found.goal_rate.mean, digits=2)
        rows.append((found.driver, *rates, shown(found.mean_delay.mean, 1.0, 2), shown(found.waited_share.mean)))
    return Table(columns, tuple(rows))


def _numbers(results: Results, driver: str, people: str) -> SeedNumbers:
    return next(x for x in results.over_seeds if (x.driver, x.pedestrians) == (driver, people))


def _populations(results: Results) -> list[str]:
    return list(dict.fromkeys(found.pedestrians for found in results.over_seeds))


def _seeds(results: Results) -> tuple[int | None, ...]:
    """Return the training seeds."""
    return _numbers(results, ALONE, ALWAYS_GO).training_seeds
