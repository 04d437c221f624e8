"""`jaxwalk rate`: make the page on which people rate drivers, and analyse what they answer."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from jaxwalk.evaluation import evaluate, named
from jaxwalk.evaluation.document_parts import ScenarioSet
from jaxwalk.exports.gallery import Cast
from jaxwalk.exports.replays import recording
from jaxwalk.interfaces import Policy
from jaxwalk.metrics import Rows, summarise
from jaxwalk.provenance import provenance
from jaxwalk.raters import (
    RatedDrivers,
    RatingError,
    RatingPlan,
    analyse,
    answers_page,
    read_answers,
    write_rating_page,
)
from jaxwalk.raters.rating_choice import choose_pairs, measures_of
from jaxwalk.scenarios import Drawn
from jaxwalk.writing import together, write_whole

PAGE, PLAN, FOUND = "rate.html", "plan.json", "ratings"
"""The page, what is behind it, and the analysis (``.md`` and ``.json``) in a folder."""


def make_rating(
    folder: Path, cast: Cast, blind: Mapping[str, Policy], *, episodes: int, each: int, say: Callable[[str], None]
) -> Path:
    """Write the page for raters and its plan into the folder; return the page's path.

    Args:
        folder: must exist.
        cast: the drivers to rate, and the one population that they meet.
        blind: a driver that hits people, for the checks; it may be one of the rated ones.
        episodes: scenarios that everybody plays, from which clips are chosen and our numbers are computed.
        each: pairs that each rater sees.
        say: called with a line of progress.

    Raises:
        RatingError: the scenarios don't have what a page needs.
    """
    ((people, policy),) = cast.populations.items()
    players = {**cast.drivers, **blind}
    source = Drawn(cast.street, cast.seed, episodes)
    rows: dict[str, Rows] = {}
    for name, driver in players.items():
        say(f"    {name} among {people}")
        with named({"driver": name, "pedestrian": people}):
            rows[name] = evaluate(cast.street, {"driver": driver, "pedestrian": policy}, source)
    plan = RatingPlan(
        drivers=tuple(cast.drivers),
        players=tuple(players),
        pedestrians=people,
        scenarios=ScenarioSet.of(source),
        seed=cast.seed,
        each=each,
        pairs=choose_pairs(rows, len(cast.drivers), each=each, seed=cast.seed),
        measures=measures_of([summarise(rows[name]) for name in cast.drivers]),
        made=provenance(),
    )
    say("    recording clips")
    numbers = sorted({pair.scenario for pair in plan.pairs})
    document = recording(cast.street, players, cast.populations, {people: numbers}, Drawn(cast.street, cast.seed))
    with together():
        write_whole(folder / PLAN, _json(plan.as_dict()))
        write_rating_page(folder / PAGE, plan, document)
    return folder / PAGE


def analyse_answers(folder: Path, plan: RatingPlan, paths: Sequence[Path]) -> RatedDrivers:
    """Analyse files of answers to the page of a plan, and write the analysis into the folder.

    Raises:
        RatingError: no attentive rater answered anything.
        AnswersError: a file is not one of answers to this page.
        DocumentError: a file is damaged.
    """
    files = read_answers(paths, plan)
    try:
        found = analyse(plan, files)
    except ValueError as error:
        raise RatingError(f"{folder}: {error}; ask more people") from error
    with together():
        write_whole(folder / f"{FOUND}.json", _json(found.as_dict()))
        write_whole(folder / f"{FOUND}.md", answers_page(plan, found))
    return found


def _json(content: object) -> str:
    return json.dumps(content, indent=1, allow_nan=False) + "\n"
