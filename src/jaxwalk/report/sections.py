"""The order of the report, and what is said about each table and figure."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Section:
    """A heading with a caption, a figure, a table, or both."""

    heading: str
    source: str
    """Where the paper has it."""
    caption: str
    figure: str | None = None
    table: str | None = None
    over_seeds: bool = False
    """It shows all training seeds; else the first one's drivers and pedestrians."""


INTERVALS = "Bars and brackets: 95 % intervals. Open diamonds: the paper."

SECTIONS = (
    Section(
        "Who reaches the goal",
        "figure 3",
        "Goals and collisions of every driver on the same scenarios, among people who always go and among the "
        f"co-trained ones. {INTERVALS} The paper's figure mixes populations and does not say among whom its rules "
        "drove; its trained drivers have a diamond for each population.",
        "baselines",
        "baselines",
        over_seeds=True,
    ),
    Section(
        "Co-training against training alone",
        "table III",
        "The car trained alone (among always-go) and the one trained with its pedestrians, with equally many "
        "updates from equally many environments of their own, each among both populations.",
        table="co_training",
        over_seeds=True,
    ),
    Section(
        "Collisions against time",
        "",
        "Mean time to the goal of those that reach it, and collisions (on a logarithmic axis; below 0.01 % as 0.01 %), "
        "a sign for each training seed. The line joins the drivers that no other beats in both.",
        "frontier",
        over_seeds=True,
    ),
    Section(
        "Every driver among every population",
        "",
        "What neither reaches the goal nor collides in 50 s has timed out.",
        table="matrix",
        over_seeds=True,
    ),
    Section(
        "Each training seed",
        "",
        "The same trainings with other random numbers: networks at the start, scenarios, actions. Intervals are over "
        "the scenarios of the evaluation.",
        table="training_seeds",
        over_seeds=True,
    ),
    Section(
        "The same scenarios in pairs",
        "",
        "Do people who learned to wait lower a driver's collisions, and does co-training? A pair is a scenario (of a "
        "training seed, if there are several); the last counts are of pairs that end so on one side alone. p is the "
        "exact McNemar test over all pairs, as if they were independent: it is about these very policies. The "
        "difference's interval is by bootstrap over scenarios and, of several, over training seeds: then it is about "
        "training again. Holm's p may be read for all comparisons of the table at once.",
        table="pairs",
        over_seeds=True,
    ),
    Section(
        "Speed near jaywalkers and near crosswalk users",
        "figure 4, equation 2",
        "Mean speed of the co-trained car among learned pedestrians, by the distance to the nearest pedestrian of "
        f"each type who is on a roadway. {INTERVALS} Left every frame weighs alike, as in the paper; right every "
        "encounter does. In the table also: matched, where only cars at nearly the same place, headed the same way and "
        "as fast at first are compared; ghosts, people whom the car cannot see; and what the difference near people is "
        "beyond that near ghosts (some of it the waiting of learned people, who are no ghosts).",
        "speed_differential",
        "speed_differential",
    ),
    Section(
        "Which collisions are jaywalking's",
        "section IV-B",
        "Jaywalking's share of the co-trained car's collisions beside its share of what there was to collide with. A "
        f"share of collisions larger than the share of exposure means more risk. {INTERVALS}",
        "attribution",
        "attribution",
    ),
    Section("What was hit", "", "The co-trained car's collisions by what the pedestrian was doing.", table="contacts"),
    Section(
        "Jaywalking follows the trait",
        "section IV-B",
        f"Share of crossing decisions that are jaywalks, by quarter of the trait. {INTERVALS}",
        "quarters",
        "quarters",
    ),
    Section(
        "Who waits at the kerb",
        "",
        "How often learned pedestrians about to step into a roadway wait, by the car's distance and speed and by how "
        "close the two would come if they went on (predicted miss), with themselves ahead of the car and within 40 m. "
        "Bars and brackets: 95 % intervals. In the table, danger: the car also faster than 2 m/s, and a predicted miss "
        "below 2.5 m; harmless: it is farther than 40 m, or past. Bins of fewer than 20 moments are not drawn. The "
        "share of all steps, and the pace, are the price of waiting.",
        "waiting",
        "waiting",
    ),
    Section(
        "How near the car comes",
        "section IV-B",
        "An encounter: a crossing with the car within 20 m and closing, until the pedestrian leaves the road.",
        table="approach",
    ),
    Section(
        "How soon the car brakes",
        "section IV-B",
        "Time from a pedestrian's road entry to the car's braking onset, co-trained driver. The median "
        "(Kaplan-Meier) counts those who never brake; a dash means that fewer than half brake while the pedestrian "
        "is on the road.",
        table="braking",
    ),
    Section(
        "More and less jaywalking",
        "section IV-D",
        f"The co-trained driver, evaluated but not retrained, with other jaywalk multipliers. {INTERVALS}",
        "ablation",
        "ablation",
        over_seeds=True,
    ),
    Section(
        "How the two drivers learned",
        "",
        "Endings of the episodes that ended in each update (running mean over a twentieth of the training); of several "
        "training seeds, a thin line for each, and their interquartile mean. In "
        "training the car samples its actions, and at first only short episodes have ended: the evaluation has the "
        "numbers to go by.",
        "learning_curves",
        over_seeds=True,
    ),
)
"""The report, from top to bottom; the page adds the summary before and one episode after."""
