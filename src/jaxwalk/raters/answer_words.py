"""The page of an analysis of raters' answers, as Markdown: first in words what may be said."""

from __future__ import annotations

from jaxwalk.raters.answers_analysis import FEWEST_RATERS, FIRM, RatedDrivers
from jaxwalk.raters.rating_plan import RatingPlan
from jaxwalk.report.table import Table, shown
from jaxwalk.wording import counted

ABOUT = (
    "Strengths are those of Davidson's model (Bradley and Terry's with ties), with a ridge of 0.1; their mean is 0: "
    "a driver ahead by 1 is preferred 2.7 times as often as the other one, ties apart. Brackets: 95 % intervals over "
    "raters (bootstrap); that of alpha is over pairs."
)
MEASURES = (
    "Kendall's tau between the raters' order of the drivers and that of our numbers, each turned so that more means "
    "safer: 1 is the same order, -1 the opposite. Of few drivers it says little."
)


def answers_page(plan: RatingPlan, found: RatedDrivers) -> str:
    """Return the page."""
    rows = tuple((one.driver, shown(one.strength, 1.0, 2), f"{one.compared:,}") for one in found.drivers)
    taus = tuple((one.name, shown(one.tau, 1.0, 2), f"{one.drivers}") for one in found.measures)
    parts = [
        "# What raters say",
        f"**{headline(found)}**",
        f"{agreement_said(found)} {_who(found)}",
        f"The question was: {plan.question} Clips are of {plan.scenarios.name}, among {plan.pedestrians}; plan "
        f"{plan.id}.",
        "## The drivers",
        ABOUT,
        Table(("driver", "strength", "answers"), rows).markdown(),
        "## Beside our numbers",
        MEASURES,
        Table(("number", "tau", "drivers"), taus).markdown(),
    ]
    return "\n\n".join(parts) + "\n"


def headline(found: RatedDrivers) -> str:
    """Return what may be said about the drivers."""
    if found.agreement == "unknown":
        few = found.raters < FEWEST_RATERS
        why = f"it takes {FEWEST_RATERS}" if few else "their answers vary too little, or too few rated the same pairs"
        passed = f"{counted(found.raters, 'rater')} passed the checks"
        return f"Which driver people find safer cannot be judged: {passed}, and {why}."
    if found.agreement == "chance":
        return "The raters disagree: which driver people find safer cannot be said."
    first, second = found.drivers[:2]
    share = "" if found.agreement == "firm" else ", though they agree only in part"
    if found.lead.low is not None and found.lead.low > 0:
        return f"The raters find {first.driver} safer than {second.driver}, who comes next{share}."
    return f"The raters put {first.driver} first, but not surely before {second.driver}{share}."


def agreement_said(found: RatedDrivers) -> str:
    """Return how far the raters agree."""
    number = shown(found.alpha, 1.0, 2)
    said = {
        "unknown": "How far they agree is unknown",
        "chance": "They do not surely agree more than by chance",
        "partial": f"They agree more than by chance, but less than firm conclusions take ({FIRM})",
        "firm": "They agree",
    }[found.agreement]
    against = f" {counted(found.against, 'rater')} contradict{'s' * (found.against == 1)} this order in most answers."
    return f"{said}: Krippendorff's alpha is {number}.{against if found.against else ''}"


def _who(found: RatedDrivers) -> str:
    alike, repeated = found.repeated
    left_out = f", {len(found.inattentive)} more failed a check and are left out" if found.inattentive else ""
    again = f" Of {counted(repeated, 'repeated pair')} {alike} were answered alike." if repeated else ""
    return (
        f"{counted(found.raters, 'rater')} gave {counted(found.answers, 'answer')}, of which {found.ties:,} call "
        f"neither car safer{left_out}.{again}"
    )
