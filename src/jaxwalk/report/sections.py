"""The order of the report, and the text about each table and figure."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from jaxwalk.metrics import FEWEST_SEEDS
from jaxwalk.report import avoidable_tables, driving_tables, published
from jaxwalk.report.material import ALWAYS_GO, Material
from jaxwalk.report.published import TRAINED


@dataclass(frozen=True)
class Section:
    """A heading with a caption, a figure, a table, or both."""

    heading: str
    source: str
    """Place of the original in the paper."""
    caption: str
    """``{subject}``, ``{crowd}`` and ``{first}`` (population) stand for names of the `Material`, ``{beside}`` for its
    rival, ``{time}`` for the longest time of an episode."""
    figure: str | None = None
    table: str | None = None
    over_seeds: bool = False
    """Whether it shows all training seeds; else it shows the first one's drivers and pedestrians."""
    applies: Callable[[Material], bool] = lambda material: True
    """Whether there is something to show."""
    theirs: str = ""
    """What the caption adds where the paper's numbers stand beside ours."""
    compares: Callable[[Material], bool] = lambda material: material.beside_paper
    """Whether the paper has numbers to stand beside ours."""

    @property
    def name(self) -> str:
        """Its name in the page: its table's, or else its figure's."""
        return self.table or self.figure or ""

    def said(self, material: Material) -> str:
        """Return the caption with the names of the drivers and populations shown."""
        beside = f" and {material.rival} (dashed)" if material.rival else ""
        street = material.results.street
        time = "its time" if street is None else f"{street.sim.horizon * street.sim.dt:g} s"
        caption = f"{self.caption} {self.theirs}" if self.theirs and self.compares(material) else self.caption
        return caption.format(
            subject=material.subject, beside=beside, crowd=material.crowd, first=material.populations[0], time=time
        )


INTERVALS = "Bars and brackets: 95 % intervals."
DIAMONDS = "Open diamonds: the paper's drivers."

SECTIONS = (
    Section(
        "Who reaches the goal",
        "figure 3",
        "Goals and collisions of every driver on the same scenarios, among each population. "
        f"{INTERVALS} A good driver has its goals far right and its collisions far left; where the colours lie far "
        "apart, much depends on the people that it meets.",
        "baselines",
        "baselines",
        over_seeds=True,
        theirs=f"{DIAMONDS} The paper's figure mixes populations and does not say among which people its rules drove; "
        "its trained drivers have a diamond for each population.",
        compares=lambda m: m.beside_paper and any(driver in published.DRIVERS for driver in m.drivers),
    ),
    Section(
        "Co-training against training alone",
        "table III",
        "The car trained alone (among always-go) and the one trained with its pedestrians, with equally many updates "
        "from equally many environments of their own, each among the same people. Compare two drivers in one "
        "population for what training together did to the car, one driver in both for what it did to the people.",
        applies=lambda m: m.trainings is not None and all(m.met(*pair) for pair in TRAINED),
        table="co_training",
        over_seeds=True,
    ),
    Section(
        "Collisions against time",
        "",
        "Mean time to the goal of those that reach it, and collisions (on a logarithmic axis; below 0.01 % as 0.01 "
        "%), a sign for each training seed. Left and low is good: who is low but far right is safe because it creeps. "
        "The line joins the drivers that no other beats in both.",
        "frontier",
        over_seeds=True,
    ),
    Section(
        "Every driver among every population",
        "",
        "What neither reaches the goal nor collides in {time} has timed out. Few collisions with many timeouts are a "
        "car that waits, not one that drives well.",
        table="matrix",
        over_seeds=True,
    ),
    Section(
        "Each training seed",
        "",
        "The same trainings with other random numbers: networks at the start, scenarios, actions. Intervals are over "
        "the scenarios of the evaluation: where seeds lie farther apart than these are wide, training itself is a "
        "matter of luck.",
        applies=lambda m: m.several,
        table="training_seeds",
        over_seeds=True,
    ),
    Section(
        "The same scenarios in pairs",
        "",
        "Which of two lets the same scenarios end better? A pair is a scenario (of a "
        "training seed, if there are several); the last counts are of pairs that end so on one side alone. Of one "
        "training seed, p is the exact McNemar test: it is about these very policies. Of several, p and the "
        "difference's interval are those of a t-test over the seeds, which all played the same scenarios: they are "
        f"about training again, and with fewer than {FEWEST_SEEDS} seeds that cannot be judged. Holm's p may be read "
        "for all comparisons of the table at once.",
        applies=lambda m: bool(m.results.paired),
        table="pairs",
        over_seeds=True,
    ),
    Section(
        "Speed near jaywalkers and near crosswalk users",
        "figure 4, equation 2",
        "Mean speed of {subject} among {crowd} pedestrians, by the distance to the nearest pedestrian of "
        f"each type who is on a roadway. {INTERVALS} Left every frame weighs alike, in the middle every encounter "
        "does. Where the car is faster near jaywalkers, red is above blue, and at the right points are above 0. In the "
        "table also: matched, where only cars at nearly the "
        "same place, headed the same way and as fast at first are compared; ghosts, people that the car cannot see; "
        "and what the difference near people is beyond that near ghosts (some of it the waiting of learned people, "
        "who are no ghosts).",
        "speed_differential",
        "speed_differential",
        theirs=f"{DIAMONDS} It weighs frames, and found the car faster near jaywalkers, most so when nearest.",
    ),
    Section(
        "The jaywalker, or the place?",
        "equation 2",
        "The same difference of {subject}, estimated five ways, from the one most open to other causes to "
        "the least; distances with fewer than 20 encounters of either type are left out. Bars: 95 % intervals. Above "
        "0 the car is faster near jaywalkers. What is as large near ghosts (grey), which it cannot see, is the place's "
        "doing; what is left of people minus ghosts (red) is the car's answer to people, and among people who always "
        "go, 0 for a car that heeds nobody.",
        "surprise",
    ),
    Section(
        "Which collisions are jaywalking's",
        "section IV-B",
        "Jaywalking's share of the collisions of {subject} beside its share of what there was to collide with. A "
        f"share of collisions larger than the share of exposure means more risk. {INTERVALS}",
        "attribution",
        "attribution",
        theirs=DIAMONDS,
    ),
    Section(
        "Collisions, by what people did",
        "",
        "The collisions of {subject} by what the pedestrian was doing. With a car that stands, it was the "
        "pedestrian who walked into it.",
        table="contacts",
    ),
    Section(
        "Jaywalking follows the trait",
        "section IV-B",
        "Share of crossing decisions that are jaywalks, by quarter of the trait. It should rise by equal steps. "
        f"{INTERVALS}",
        "quarters",
        "quarters",
        theirs=DIAMONDS,
    ),
    Section(
        "Who waits at the kerb",
        "",
        "How often {crowd} pedestrians about to step into a roadway wait, by the car's distance and speed and by how "
        "close the two would come if they went on (predicted miss), with themselves ahead of the car and within 40 m. "
        "Bars and brackets: 95 % intervals. In the table, danger: the car also faster than 2 m/s, and a predicted "
        "miss below 2.5 m; harmless: it is farther than 40 m, or past. Bins of fewer than 20 moments are not drawn. "
        "The share of all steps, and the pace, are the price of waiting. People who heed the car wait the more, the "
        "nearer it is and the closer the miss (red above grey); before a driver that heeds nobody, more than before "
        "one that does.",
        "waiting",
        "waiting",
        applies=lambda m: m.crowd != ALWAYS_GO and ALWAYS_GO in m.populations,
    ),
    Section(
        "Would a careful human have avoided it?",
        "",
        avoidable_tables.JUDGED,
        table="preventable",
        applies=lambda m: any(cell.counterfactuals for cell in m.results.cells),
    ),
    Section("Who goes first at the kerb", "", driving_tables.KERB, table="kerb"),
    Section("How the car drives", "", driving_tables.DRIVING, table="driving"),
    Section(
        "How near the car comes",
        "section IV-B",
        "An encounter: a crossing with the car within 20 m and closing, until the pedestrian leaves the road. One in "
        "twenty encounters comes nearer than the number shown. Distances are between the centres; below 1.5 m is a "
        "collision by the paper's rule.",
        table="approach",
    ),
    Section(
        "How near to a collision",
        "",
        "Of all encounters with {first} pedestrians, the share beyond each "
        "threshold of four measures (metrics.md says how they are computed), for {subject} (solid){beside}; "
        "bands: 95 % intervals over episodes. A lower curve is safer at every threshold, "
        "not only at the critical one (dotted). Red above blue: encounters with jaywalkers are the more dangerous "
        "ones. A curve of fewer than 20 encounters is not drawn.",
        "surrogates",
    ),
    Section(
        "How soon the car brakes",
        "section IV-B",
        "Time from a pedestrian's road entry to the braking onset of {subject}. The median (Kaplan-Meier) "
        "counts those who never brake; a dash means that fewer than half brake while the pedestrian is on the road. "
        "A longer time for jaywalkers than for crosswalk users would be the car's surprise.",
        table="braking",
    ),
    Section(
        "More and less jaywalking",
        "section IV-D",
        "The co-trained driver, evaluated but not retrained, with other jaywalk multipliers. The steeper goals fall "
        "and collisions rise to the right, the less it copes with more jaywalkers than it met in training (0.25). "
        f"{INTERVALS}",
        "ablation",
        "ablation",
        over_seeds=True,
        theirs=DIAMONDS,
        applies=lambda m: m.ablation is not None,
    ),
    Section(
        "How the drivers learned",
        "",
        "Endings of the episodes that ended in each update (running mean over a twentieth of the training); of "
        "several training seeds, a thin line for each, and their interquartile mean. In training the car samples its "
        "actions, and at first only short episodes have ended: the evaluation has the numbers to go by. Goals should "
        "rise and level off before the end; if they still rise, more training would help.",
        "learning_curves",
        over_seeds=True,
        applies=lambda m: bool(m.curves),
    ),
)
"""The report, from top to bottom; the page adds the summary before and one episode after."""
