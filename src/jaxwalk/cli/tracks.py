"""``jaxwalk tracks``."""

from __future__ import annotations

from rich.console import Console
from rich.progress import Progress

from jaxwalk.cli.casting import cast
from jaxwalk.cli.checks import check_driver, check_episodes, check_file, check_seed
from jaxwalk.cli.options import Tracks
from jaxwalk.evaluation import jaywalk_multiplier, named
from jaxwalk.exports.track_table import record_tracks
from jaxwalk.formats.track_file import check_parquet
from jaxwalk.maps import map_labels
from jaxwalk.runs.folder import check_writable
from jaxwalk.scenarios import Drawn
from jaxwalk.wording import counted


def run(options: Tracks) -> int:
    """Play the episodes and write the file."""
    check(options)
    street, drivers, people = cast([options.driver], [options.pedestrians], options)
    (driver,), (crowd,) = drivers.values(), people.values()
    options.out.parent.mkdir(parents=True, exist_ok=True)
    about = {
        "map": ", ".join(map_labels(street.maps)), "driver": options.driver, "pedestrians": options.pedestrians,
        "jaywalk_multiplier": jaywalk_multiplier(street), "seed": options.seed,
    }  # fmt: skip
    who = {"driver": options.driver, "pedestrian": options.pedestrians}
    with named(who), Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("playing", total=options.episodes)
        record_tracks(
            street, {"driver": driver, "pedestrian": crowd}, Drawn(street, options.seed, options.episodes), options.out,
            about=about, progress=lambda played, _: bar.update(task, completed=played),
        )  # fmt: skip
    which = f"scenarios 0 to {options.episodes - 1}" if options.episodes > 1 else "scenario 0"
    print(f"{options.out}: {counted(options.episodes, 'episode')}, {which} of seed {options.seed}")
    return 0


def check(options: Tracks) -> None:
    """Raise an error for impossible options."""
    check_driver(options.driver)
    check_episodes(options.episodes)
    check_seed(options.seed)
    check_file(options.out, ".parquet")
    check_parquet()
    check_writable(options.out.parent)
