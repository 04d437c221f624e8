"""``jaxwalk play``."""

from __future__ import annotations

from pathlib import Path

from jaxwalk.cli.casting import Policies, cast
from jaxwalk.cli.checks import (
    check_driver,
    check_driver_seconds,
    check_kept,
    check_no_folder,
    check_number,
    check_scenario,
    check_seed,
)
from jaxwalk.cli.errors import UsageError
from jaxwalk.cli.options import Play
from jaxwalk.evaluation import named
from jaxwalk.exports.drawn_episode import MOVING, draw_episode
from jaxwalk.exports.replays import recording
from jaxwalk.interfaces import Policy
from jaxwalk.policies.shield_names import with_shield
from jaxwalk.runs.folder import check_writable
from jaxwalk.scenarios import Archived, Drawn
from jaxwalk.scenarios.archive_file import read_archive
from jaxwalk.wording import counted

Kept = Drawn | Archived
"""Scenarios that know their street."""
PAGE = ".html"
"""Ending of a page on which episodes can be played."""
STILL = (".png", ".svg", ".pdf")
"""Endings of pictures."""


def run(options: Play) -> int:
    """Play the episodes and write them to the file."""
    out = check(options)
    names = with_shield(options.driver, options.shield)
    kept = read_archive(options.scenarios) if options.scenarios else None
    for number in options.scenario:
        check_number(number, kept)
    loading = {"trust": options.trust, "seconds": options.driver_seconds}
    street, drivers, people = cast(names, [options.pedestrians], options, kept, **loading)
    source = Drawn(street, options.seed) if kept is None else kept
    out.parent.mkdir(parents=True, exist_ok=True)
    show = _page if out.suffix.lower() == PAGE else _drawing
    older = out.exists()
    said = show(options, out, source, drivers, people[options.pedestrians])
    print(f"{out}: {said}{' (replaces an older file)' if older else ''}")
    return 0


def _drawing(options: Play, out: Path, source: Kept, drivers: Policies, people: Policy) -> str:
    ((name, driver),), (scenario,) = drivers.items(), options.scenario
    policies = {"driver": driver, "pedestrian": people}
    with named({"driver": name, "pedestrian": options.pedestrians}):
        played = draw_episode(source.street, policies, source, scenario, out, time=options.time)
    ending = "goal" if played.goal[0] else "collision" if played.collision[0] else "timeout"
    return f"scenario {scenario} of {_where(options)}: {ending} after {played.length[0] * played.dt:.1f} s"


def _page(options: Play, out: Path, source: Kept, drivers: Policies, people: Policy) -> str:
    from jaxwalk.viewer import replay_page

    numbers = list(dict.fromkeys(options.scenario))
    name = options.pedestrians
    document = recording(source.street, drivers, {name: people}, {name: numbers}, source)
    among = f"{', '.join(drivers)} among {name}"
    replay_page(document, out, title=f"jaxwalk: {among}")
    return f"{counted(len(document['episodes']), 'episode')} of {_where(options)}, {among}; open it in a browser"


def _where(options: Play) -> str:
    """Return where the scenarios are from."""
    return str(options.scenarios) if options.scenarios else f"seed {options.seed}"


def check(options: Play) -> Path:
    """Raise an error for impossible options; return the file to write."""
    check_driver(options.driver)
    for scenario in options.scenario:
        check_scenario(scenario)
    if not options.scenario:
        raise UsageError("--scenario needs a number, such as 3")
    check_seed(options.seed)
    if options.scenarios:
        check_kept(options)
    check_driver_seconds(options.driver_seconds)
    if options.html and options.out:
        raise UsageError("--html is short for --out episode.html: give one of the two")
    out = options.out or Path("episode.html" if options.html else "episode.png")
    _check_file(options, out)
    check_writable(out.parent)
    return out


def _check_file(options: Play, out: Path) -> None:
    kind, kinds = out.suffix.lower(), (PAGE, *STILL, *MOVING)
    if kind not in kinds:
        raise UsageError(f"--out {out}: the name must end in one of {', '.join(kinds)}")
    check_no_folder(out)
    if kind != PAGE and (len(options.driver) > 1 or len(options.scenario) > 1):
        raise UsageError(f"--out {out}: shows one driver in one scenario; several only on a page (--html)")
    if options.time is not None and not 0 <= options.time < float("inf"):
        raise UsageError(f"--time must be a finite number of 0 or more, not {options.time}")
    if options.time is not None and kind not in STILL:
        raise UsageError(f"--time is the moment of a picture ({', '.join(STILL)}), not of {out}")
    if kind == ".mp4":
        _check_film(out)


def _check_film(out: Path) -> None:
    from importlib.util import find_spec

    if find_spec("imageio_ffmpeg") is None:
        raise UsageError(f"--out {out}: MP4 needs `pip install 'jaxwalk[video]'`; or name a .gif")
