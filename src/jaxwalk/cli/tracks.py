"""``jaxwalk tracks``."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from jaxwalk.cli.options import Tracks, UsageError
from jaxwalk.cli.train import bad_values
from jaxwalk.evaluation import with_jaywalk_multiplier
from jaxwalk.exports.track_table import record_tracks
from jaxwalk.formats.track_file import check_parquet
from jaxwalk.runs.contestants import contestant, world_of
from jaxwalk.runs.folder import Run, check_writable


def run(options: Tracks) -> int:
    """Play and write."""
    check(options)
    names = [options.driver, options.pedestrians]
    with bad_values():
        street = world_of(names, [options.map] if options.map else [])
        street = with_jaywalk_multiplier(street, options.jaywalk_multiplier)
        driver = contestant(street, "driver", options.driver)
        people = contestant(street, "pedestrian", options.pedestrians)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    about = {
        "map": options.map or map_name(names), "driver": options.driver, "pedestrians": options.pedestrians,
        "jaywalk_multiplier": options.jaywalk_multiplier,
    }  # fmt: skip
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("playing", total=options.episodes)
        record_tracks(
            street, driver, people, options.out, episodes=options.episodes, seed=options.seed, about=about,
            progress=lambda played, _: bar.update(task, completed=played),
        )  # fmt: skip
    print(f"{options.out}: {options.episodes:,} episodes, scenarios 0 to {options.episodes - 1} of seed {options.seed}")
    return 0


def map_name(names: list[str]) -> str:
    """Of the map that run folders among the names were trained on, else of the paper's."""
    trained = [Run.open(name).experiment.maps for name in names if Path(name).is_dir()]
    return trained[0][0] if trained else "paper"


def check(options: Tracks) -> None:
    """Raise for options that can't be."""
    if not options.driver:
        raise UsageError(
            "--driver is missing: a name such as co-trained or route-follower, a run folder or a policy file"
        )
    if options.episodes < 1:
        raise UsageError(f"--episodes must be at least 1, not {options.episodes}")
    if not 0 <= options.seed < 2**31:
        raise UsageError(f"--seed must lie in [0, 2^31), not {options.seed}")
    if options.out.suffix != ".parquet":
        raise UsageError(f"--out {options.out}: the name must end in .parquet")
    if options.out.is_dir():
        raise UsageError(f"--out {options.out}: is a folder; name a file")
    check_parquet()
    check_writable(options.out.parent)
