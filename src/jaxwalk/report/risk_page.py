"""Write the results of `jaxwalk risk-aware` as a Markdown page, which begins with an answer in words."""

from __future__ import annotations

from collections.abc import Sequence

from jaxwalk.evaluation.harm_numbers import PairedHarm
from jaxwalk.metrics import FEWEST_SEEDS, SURE, holm
from jaxwalk.report.risk_document import LimitKept, RiskDocument
from jaxwalk.report.seed_tables import delay_table, harm_table, paired_table
from jaxwalk.report.table import MOVING, Table, p_in_words, shown
from jaxwalk.wording import counted

PLAIN, LAGRANGIAN, CVAR = "plain", "lagrangian", "cvar"
"""The trainings: without limits; with limits of contacts and of time near one; with one of the worst speeds."""

ABOUT = (
    "`plain` is the recipe `blind-corner`, `lagrangian` is `blind-corner-lagrangian`, `cvar` is `blind-corner-cvar`. "
    "They differ in limits of costs alone, and all have equally many updates. Everybody drives on the same scenarios "
    "among people who always go. `clearance` is a rule."
)
TABLES = (
    "Worst hundredth: the car's speed in the contact that ends an episode, 0 without one, on average over the "
    "hundredth of the episodes in which it is highest (the conditional value at risk at 0.99). Touched: episodes in "
    "which the moving car touched somebody by its footprint. Delay: seconds beyond untouchable full throttle on the "
    "same scenario, where the car arrives."
)


def page(document: RiskDocument, *, updates: int) -> str:
    """Return the answer and all tables; ``updates`` are those of each training."""
    chosen, made = document.results.scenarios, document.results.made
    seeds = sorted({seed for tail in document.tails for seed in tail.training_seeds if seed is not None})
    origin = "" if made is None else f"; commit {made.commit or 'unknown'}, {made.hardware}"
    parts = [
        "# Does learning with limits make the worst contacts slower?",
        answer(document),
        ABOUT,
        f"Training seeds: {', '.join(map(str, seeds))}; {counted(updates, 'update')} each. {chosen.name}, hash "
        f"{chosen.hash}{origin}. Brackets are 95 % t-intervals over training seeds and scenarios (of the rule, over "
        "scenarios).",
        TABLES,
        _drivers(document).markdown(),
        f"## Against `{PLAIN}`",
        harm_table(document.compared).markdown(),
        paired_table(document.results.paired).markdown(),
        delay_table(document.results.paired_delays).markdown(),
        "## Were the limits kept in training?",
        _limits(document.limits).markdown(),
    ]
    return "\n\n".join(parts) + "\n"


def answer(document: RiskDocument) -> str:
    """Return whether the limits make the worst contacts slower, as far as the numbers tell."""
    found = document.compared
    if any(one.p is None for one in found):
        return (
            "**Whether limits make the worst contacts slower cannot be judged**: a sentence about training takes "
            f"{FEWEST_SEEDS} training seeds that differ."
        )
    adjusted = holm([one.p for one in found if one.p is not None])
    return " ".join(_verdict(one, p) for one, p in zip(found, adjusted, strict=True))


def _verdict(one: PairedHarm, p: float) -> str:
    """Return what is known of one training against the plain one."""
    difference = shown(one.difference, 1.0, 2)
    if p >= SURE:
        return f"**No effect of `{one.b}` on the worst contacts is shown**: {difference} m/s, {p_in_words(p)}."
    side = "slower" if (one.difference.value or 0) < 0 else "faster"
    return f"**The worst contacts of `{one.b}` are {side} than those of `{one.a}`**: {difference} m/s, {p_in_words(p)}."


def _drivers(document: RiskDocument) -> Table:
    columns = ("driver", "worst hundredth [m/s]", "of each seed", MOVING, "goal %", "delay [s]")
    numbers = {found.driver: found for found in document.results.over_seeds}
    rows = []
    for tail in document.tails:
        found = numbers[tail.driver]
        each = ", ".join(f"{value:.2f}" for value in tail.number.each if value is not None)
        rates = (shown(rate.mean, digits=2) for rate in (found.moving_contact_rate, found.goal_rate))
        worst = shown(tail.number.mean, 1.0, 2)
        rows.append((tail.driver, worst, each, *rates, shown(found.mean_delay.mean, 1.0, 2)))
    return Table(columns, tuple(rows))


def _limits(limits: Sequence[LimitKept]) -> Table:
    """Return each limit with what the trainings reached in their last updates, one number for each seed."""
    columns = ("driver", "cost", "limit", "reached in the last updates", "multiplier at the end")
    groups: dict[tuple[str, str, float], list[LimitKept]] = {}
    for one in limits:
        groups.setdefault((one.driver, one.cost, one.limit), []).append(one)
    rows = []
    for (driver, cost, limit), group in groups.items():
        reached, multipliers = (
            ", ".join(f"{getattr(one, name):.3g}" for one in group) for name in ("reached", "multiplier")
        )
        rows.append((driver, cost, f"{limit:g}", reached, multipliers))
    return Table(columns, tuple(rows))
