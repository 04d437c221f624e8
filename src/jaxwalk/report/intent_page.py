"""Write the document of `jaxwalk hidden-intent` as a Markdown page."""

from __future__ import annotations

from collections.abc import Sequence

from jaxwalk.evaluation.document_parts import Interval, PairedSeeds
from jaxwalk.evaluation.equal_delay import EqualDelay
from jaxwalk.evaluation.training_seeds import Ending
from jaxwalk.metrics import FEWEST_SEEDS, SURE
from jaxwalk.report.intent_document import IntentStreet, KnownIntent, priced
from jaxwalk.report.material import ALWAYS_GO, CLEARANCE
from jaxwalk.report.seed_tables import delay_table, harm_table, paired_table
from jaxwalk.report.table import MOVING, NONE, Table, adjusted, p_in_words, p_value, shown
from jaxwalk.sim.observation import PRIVILEGED_SETS
from jaxwalk.wording import counted

BLIND = "blind"
"""Name of the car that the others are compared with."""
TOLD = ("belief", "told", "decided")
"""Cars that are told something about people: they are also compared with the one that is told what decides nothing."""
NOTHING_MORE = "placebo"
"""Name of that one."""
ENDINGS: tuple[Ending, Ending] = ("moving contact", "goal")
"""How episodes end that are compared, beside the harm and the delay."""
KNOWS = {
    BLIND: "sees where people are and how they move, as far as its car perceives them",
    NOTHING_MORE: "is also told a number about each of the nearest people that decides nothing, so that it has as many "
    "inputs as `told`",
    "belief": "is also told the posterior mean of their jaywalking tendencies, given the crossings that it saw and, "
    "where people can be hidden, one decision of each of them from before",
    "told": "is also told the tendencies",
    "decided": "is also told who of them has decided to jaywalk, and where they will step out",
    "memory": "sees what `blind` sees, and who was last seen up to 3 s ago",
    "aware": "sees what `memory` sees, which sides of its way are hidden, and how far ahead the next crosswalk is",
    "x-ray": "sees what `blind` sees, but of everybody, hidden or not",
}
"""What each car knows, in words."""
ABOUT = (
    "Moving contacts: scenarios in which the moving car touches somebody by its footprint. Serious injuries or deaths "
    "are those to be expected in 1,000 scenarios, if contacts with the sides count as if they were with the front; "
    "even a contact at 1 m/s counts as 0.026 of one. "
    "Delay: seconds beyond untouchable full throttle on the same scenario, where the car arrives; of two cars, where "
    "both arrive."
)
SHOWING = (
    " People's pace tells of their tendency (`pace_correlation` {:g}), in the trainings and everywhere below; what "
    "could be known is of crossings alone, without pace."
)
EQUAL_ABOUT = (
    "A car that hurries may touch more people, whatever it sees. Here each was trained with several prices of time, "
    "and the difference is moved to the delay at which both are equally quick, by the change per second of delay "
    "within the trainings of one car and seed. That assumes that contacts change in proportion to the delay, and "
    "equally for both: compare the changes of A and of B."
)


def compared(cars: Sequence[str]) -> list[tuple[str, str]]:
    """Return which cars are compared: each with the blind one, and those that are told something with the placebo."""
    others = [(BLIND, car) for car in cars if car != BLIND]
    return others + [(NOTHING_MORE, car) for car in TOLD if {NOTHING_MORE, car} <= set(cars)]


def page(
    streets: Sequence[IntentStreet],
    *,
    recipe: str,
    updates: int,
    time_weights: Sequence[float],
    pace_correlation: float,
) -> str:
    """Return the answer and all tables, for each setting.

    ``recipe``, ``updates`` and ``time_weights`` (prices of time, as multiples of the recipe's) are of the trainings,
    ``pace_correlation`` (`jaxwalk.sim.sim_config.SimConfig`) is of the people in them and in all settings.
    """
    results = streets[0].results
    cars = [cell.driver for cell in results.cells if cell.driver in KNOWS]
    seeds = ", ".join(map(str, dict.fromkeys(c.training_seed for c in results.cells if c.training_seed is not None)))
    prices = (
        f" In a name, `{priced('', w)}` stands for {w:g} times the recipe's price of time."
        for w in time_weights
        if w != 1
    )
    parts = [
        "# The cost of hidden intent",
        answer(streets[0]),
        f"The same car, trained alone among {ALWAYS_GO} with the recipe `{recipe}`. "
        + " ".join(f"`{name}` {KNOWS[name]}." for name in dict.fromkeys(cars))
        + " What the critic sees is the same for all."
        + "".join(prices)
        + (SHOWING.format(pace_correlation) if pace_correlation else "")
        + f" `{CLEARANCE}` is a rule.",
        f"Training seeds: {seeds}; {counted(updates, 'update')} each. Brackets are 95 % intervals for other training "
        "seeds and other scenarios of the same streets; of the rule, for other scenarios.",
        ABOUT,
    ]
    for street in streets:
        chosen, made = street.results.scenarios, street.results.made
        origin = "" if made is None else f"; commit {made.commit or 'unknown'}, {made.hardware}"
        parts += [
            f"## {street.setting[0].upper()}{street.setting[1:]}",
            f"{chosen.name}, hash {chosen.hash}{_where(street)}{origin}.",
            *_tables(street),
        ]
    return "\n\n".join(parts) + "\n"


def _where(street: IntentStreet) -> str:
    found = street.results.street
    return "" if found is None else f"; {found.in_words()}"


def answer(street: IntentStreet) -> str:
    """Return what each kind of knowledge saves in contacts of the moving car, as far as the numbers tell."""
    found = street.results.paired
    if not found:
        return f"**Nothing was compared**: only `{BLIND}` was trained."
    if any(one.training_seeds < FEWEST_SEEDS for one in found):
        return (
            "**What hidden intent costs cannot be judged**: a sentence about training takes "
            f"{FEWEST_SEEDS} training seeds."
        )
    contacts, goals = ({(one.a.driver, one.b.driver): one for one in found if one.ending == end} for end in ENDINGS)
    p_values = dict(zip(((one.ending, one.b.driver, one.a.driver) for one in found), _holm(found), strict=True))
    later = {(one.a, one.b): one.difference for one in street.results.paired_delays}
    first = next(iter(contacts))
    touched, reached = (shown(Interval(of[first].a.rate, None, None), digits=2) for of in (contacts, goals))
    lines = [
        f"- `{b}` {_verdict(one.difference, p)} `{a}`: {_points(one.difference)}, {p_in_words(p)}. "
        f"Goals {_points(goals[a, b].difference)}, delay {shown(later[a, b], 1.0, 2, sign='+')} s."
        for (a, b), one in contacts.items()
        if (p := p_values[one.ending, b, a]) is not None
    ]
    lines += [
        f"- At equal delay `{one.b}` {_verdict(one.difference, p)} `{one.a}`: "
        f"{shown(one.difference, 1.0, 2, sign='+')} points, {p_in_words(p)}."
        for one, p in zip(street.equal_delays, _holm(street.equal_delays), strict=True)
        if one.of == MOVING and p is not None
    ]
    return (
        f"With {street.setting}, the moving car of `{BLIND}` touches somebody in {touched} % of the scenarios, and "
        f"{reached} % end at the goal. Differences are the first car's number minus the second's, in the same "
        "scenarios. The p-values are adjusted for all tests of their table (Holm), the intervals for none.\n\n"
        + "\n".join(lines)
    )


def _holm(found: Sequence[PairedSeeds] | Sequence[EqualDelay]) -> list[float | None]:
    return adjusted([one.p for one in found])


def _verdict(difference: Interval, p: float) -> str:
    """Return how B differs from A in contacts of the moving car, between their names."""
    if p >= SURE:
        return "is not shown to differ from"
    return f"touches somebody in {'fewer' if (difference.value or 0) < 0 else 'more'} scenarios than"


def _points(difference: Interval) -> str:
    return f"{shown(difference, digits=2, sign='+')} points"


def _tables(street: IntentStreet) -> list[str]:
    results = street.results
    found = [_drivers(street), paired_table(results.paired), harm_table(street.paired_harms)]
    found.append(delay_table(results.paired_delays))
    parts = [table.markdown() for table in found if table.rows]
    if street.equal_delays:
        parts += [EQUAL_ABOUT, _equal(street.equal_delays).markdown()]
    return [*parts, _known(street).markdown()]


def _drivers(street: IntentStreet) -> Table:
    observes = {cell.driver: cell.driver_observes for cell in street.results.cells}
    harms = {found.driver: found.number for found in street.harms}
    columns = (
        "driver", "observes", "goal %", MOVING, "of each seed", "serious injuries in 1,000", "timeout %", "delay [s]"
    )  # fmt: skip
    rows = []
    for found in street.results.over_seeds:
        name = found.driver
        sees = f"`{observes[name]}`" + (" (no real car could)" if observes[name] in PRIVILEGED_SETS else "")
        rates = (found.goal_rate, found.moving_contact_rate, found.timeout_rate)
        goal, moving, timeout = (shown(rate.mean, digits=2) for rate in rates)
        each = ", ".join(f"{100 * value:.2f}" for value in found.moving_contact_rate.each if value is not None)
        harm, delay = shown(harms[name].mean, 1.0, 2), shown(found.mean_delay.mean, 1.0, 2)
        rows.append((name, sees, goal, moving, each, harm, timeout, delay))
    return Table(columns, tuple(rows))


def _equal(found: Sequence[EqualDelay]) -> Table:
    columns = (
        "of", "A", "B", "B later [s]", "change per second, A", "of B", "B minus A, equally quick", "p", "p, Holm"
    )  # fmt: skip
    rows = []
    for one, p in zip(found, adjusted([one.p for one in found]), strict=True):
        numbers = (Interval(number, None, None) for number in (one.later, one.slope_a, one.slope_b))
        shares = (shown(number, 1.0, 2) for number in (*numbers, one.difference))
        rows.append((one.of, one.a, one.b, *shares, p_value(one.p), p_value(p)))
    return Table(columns, tuple(rows))


def _known(street: IntentStreet) -> Table:
    """Return the table of how much could be known (`jaxwalk.metrics.identifiability`)."""
    columns = (
        "seen", "people", "crossings of each", "never seen to cross %", "standard deviation of tau",
        "variance explained %", "information [bit]",
    )  # fmt: skip
    return Table(columns, tuple(_known_row(found) for found in street.identifiability))


def _known_row(found: KnownIntent) -> tuple[str, ...]:
    known = found.known
    if known is None:
        return (found.seen, "0", *[NONE] * 5)
    never, explained = (f"{100 * share:.1f}" for share in (known.never, known.explained))
    seen = (found.seen, f"{known.people:,}", f"{known.crossings:.2f}", never)
    return (*seen, f"{known.deviation:.3f}", explained, f"{known.bits:.3f}")
