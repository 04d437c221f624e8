"""``jaxwalk rate``."""

from __future__ import annotations

from dataclasses import fields

from rich.console import Console

from jaxwalk.cli.casting import cast
from jaxwalk.cli.checks import check_count, check_driver_seconds, check_episodes, check_seed
from jaxwalk.cli.errors import UsageError, bad_values
from jaxwalk.cli.options import Rate
from jaxwalk.experiments.rating_study import FOUND, PLAN, analyse_answers, make_rating
from jaxwalk.exports.gallery import Cast
from jaxwalk.raters import read_plan
from jaxwalk.raters.answer_words import headline
from jaxwalk.report import ROUTE_FOLLOWER
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.folder import check_writable
from jaxwalk.runs.lock import held

FEWEST, MOST = 2, 20
"""Numbers of drivers that can be rated."""
MOST_PAIRS = 200
"""Most pairs for a rater: an hour."""


def run(options: Rate) -> int:
    """Make the page for raters, or analyse their answers."""
    if options.answers:
        _check_answers(options)
        plan = read_plan(options.out / PLAN)
        with held(options.out):
            found = analyse_answers(options.out, plan, options.answers)
        print(f"{headline(found)}\nRead {options.out / f'{FOUND}.md'}")
        return 0
    check(options)
    street, drivers, people = cast(
        options.drivers, [options.pedestrians], options, trust=options.trust, seconds=options.driver_seconds
    )
    console = Console(stderr=True)
    with bad_values():
        blind = {ROUTE_FOLLOWER: contestant(street, "driver", ROUTE_FOLLOWER)}
    with held(options.out):
        page = make_rating(
            options.out, Cast(street, drivers, people, options.seed), blind, episodes=options.episodes,
            each=options.pairs, say=lambda line: console.print(line, soft_wrap=True, markup=False),
        )  # fmt: skip
    print(f"Send raters {page}; when they have sent their files: jaxwalk rate --out {options.out} --answers FILES")
    return 0


def _check_answers(options: Rate) -> None:
    """Raise UsageError for options that the page has decided already."""
    given = [f.name for f in fields(Rate) if getattr(options, f.name) != f.default and f.name not in ("answers", "out")]
    if given:
        option = given[0] if given[0] == "drivers" else f"--{given[0].replace('_', '-')}"
        raise UsageError(f"{option}: --answers analyses what {options.out / PLAN} says; leave it out")
    check_writable(options.out)


def check(options: Rate) -> None:
    """Raise an error for impossible options."""
    count = len(dict.fromkeys(options.drivers))
    if not FEWEST <= count <= MOST:
        raise UsageError(f"{FEWEST} to {MOST} different drivers can be rated, not {count}; name them as for `evaluate`")
    check_count("--pairs", options.pairs, 3, MOST_PAIRS)
    check_episodes(options.episodes)
    check_seed(options.seed)
    check_driver_seconds(options.driver_seconds)
    if (options.out / PLAN).exists():
        raise UsageError(f"--out {options.out}: answers to the page there need its {PLAN}; name another folder")
    check_writable(options.out)
