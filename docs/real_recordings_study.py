"""The study of docs/real-recordings.md: what real people and cars do at a crosswalk, and what ours do, measured alike.

    python docs/real_recordings_study.py FOLDER --out runs/real-recordings
    python docs/real_recordings_study.py FOLDER --out runs/held-out --clips test \\
        --pedestrians campus@campus always-go learned gap-acceptance always-go@campus

FOLDER holds the files intersection_*_filtered.csv of github.com/dongfang-steven-yang/vci-dataset-dut.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.evaluation import play
from jaxwalk.experiments.real_recordings import Watched, describe, distances, halves, watch_clips, watch_episodes
from jaxwalk.formats.areas import areas_of, parse_areas
from jaxwalk.formats.clip_grounds import read_clip_grounds
from jaxwalk.formats.tracks import TracksError
from jaxwalk.maps import as_network
from jaxwalk.metrics.statistics import Estimate, interval
from jaxwalk.policies.mixture_names import MixtureError
from jaxwalk.provenance import provenance
from jaxwalk.runs.contestant_names import ContestantError, check_name
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.folder import RunError
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import WORLDS
from jaxwalk.writing import write_whole

GROUND = Path(__file__).with_name("dut_ground.toml")
TOP_SPEED = WORLDS["campus"].max_speed
"""The car's top speed on our street [m/s], in every world: docs/real_recordings_calibration.py measures it."""
USUAL = "paper-footprint"
"""The world of people for whom none is named."""
PEOPLE, EPISODES, SEED = 36, 64, 77
LINES = {
    "waited": ("stopped before the car's path", 100.0, "%"),
    "pedestrian_first": ("person came first", 100.0, "%"),
    "accepted": ("accepted gap, median", 1.0, "s"),
    "crossing_speed": ("crossing speed, median", 1.0, "m/s"),
    "pet": ("post-encroachment time, median", 1.0, "s"),
    "min_distance": ("smallest distance, median", 1.0, "m"),
}


def watch_ours(driver: str, population: str, world: str, episodes: int) -> Watched:
    """Return our people, on the paper's street with slow cars."""
    street = Street.create(config=replace(WORLDS[world], max_speed=TOP_SPEED, pedestrians=PEOPLE))
    areas = parse_areas(areas_of(as_network(street.maps[0])), "the paper's street")
    scenarios, keys = Drawn(street, seed=SEED, count=episodes).take(np.arange(episodes))
    named = {"driver": driver, "pedestrian": population}
    policies = {role: contestant(street, role, name) for role, name in named.items()}
    return watch_episodes(play(street, policies, scenarios, keys), areas, street.config)


def cast(driver: str, named: list[str]) -> dict[str, tuple[str, str]]:
    """Return population and world of each name such as ``campus@campus``; without a world it is `USUAL`.

    Raises ContestantError, MixtureError or RunError if something has no such name.
    """
    check_name("driver", driver)
    found = {}
    for name in named:
        population, _, world = name.partition("@")
        check_name("pedestrian", population)
        if world and world not in WORLDS:
            raise ContestantError(f"{name}: no world {world!r}; there are: {', '.join(WORLDS)}")
        found[name] = population, world or USUAL
    return found


def written(number: dict[str, Any], scale: float = 1.0) -> str:
    """Return a number with its interval."""
    ends = [number[name] for name in ("value", "low", "high")]
    if ends[0] is None:
        return "-"
    value, *rest = (f"{scale * end:.2f}" if end is not None else "?" for end in ends)
    return f"{value} [{rest[0]}, {rest[1]}]"


def tables(document: dict[str, Any]) -> str:
    """Return the tables of the page."""
    real, everybody = document["real"], {"real": document["real"], **document["ours"]}
    lines = [
        "| where people meet a car's path | " + " | ".join(everybody) + " |",
        "| --- " * (1 + len(everybody)) + "|",
    ]
    counts = [str(one["meetings"]["waited"]["count"]) for one in everybody.values()]
    lines.append("| meetings | " + " | ".join(counts) + " |")
    for name, (words, scale, unit) in LINES.items():
        row = [written(one["meetings"][name], scale) for one in everybody.values()]
        lines.append(f"| {words}, {unit} | " + " | ".join(row) + " |")
    lines += [
        "",
        "| real cars, distance to the person | near crosswalk users, m/s | near others, m/s | difference, m/s |",
        "| --- " * 4 + "|",
    ]
    for one in real["speeds"]:
        three = " | ".join(written(one[name]) for name in ("crosswalk", "elsewhere", "difference"))
        lines.append(f"| {one['near']:g} to {one['far']:g} m | {three} |")
    lines += ["", "| real encounters | TTC < 1.5 s, % | PET < 1.5 s, % | DRAC > 3.4 m/s2, % |", "| --- " * 4 + "|"]
    for place, shares in real["encounters"].items():
        lines.append(f"| {place} | " + " | ".join(written(share, 100.0) for share in shares.values()) + " |")
    first, *others = document["ours"] or [""]
    lines += by_measure("Wasserstein-1 from real", list(document["ours"]), document["distances"])
    lines += by_measure(f"how much nearer {first} is than", others, document["nearer"]) if others else []
    return "\n".join(lines) + "\n"


def by_measure(title: str, populations: list[str], numbers: dict[str, dict[str, Any]]) -> list[str]:
    """Return the lines of a table with a row for each measure and a column for each population."""
    lines = ["", f"| {title} | " + " | ".join(populations) + " |", "| --- " * (1 + len(populations)) + "|"]
    for name, by_population in numbers.items():
        words, scale, unit = LINES[name]
        row = [written(number, scale) for number in by_population.values()]
        lines.append(f"| {words.removesuffix(', median')}, {unit} | " + " | ".join(row) + " |")
    return lines


def estimated(draws: np.ndarray) -> Estimate:
    """Return a number with its interval over recordings."""
    return interval(draws, len(draws) - 1)


def compared(away: dict[str, np.ndarray]) -> dict[str, Any]:
    """Return by how much the first population is nearer than each other one."""
    first, *others = away or [""]
    return {who: asdict(estimated(away[who] - away[first])) for who in others}


def options() -> argparse.ArgumentParser:
    """Return what can be asked for."""
    found = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    found.add_argument("folder", type=Path, help="the clips, which are no part of jaxwalk")
    found.add_argument("--ground", type=Path, default=GROUND, help="areas of the clips, as docs/dut_ground.toml")
    found.add_argument("--out", type=Path, default=Path("runs/real-recordings"))
    found.add_argument("--clips", choices=("all", "fit", "test"), default="all", help="or half, to fit or test with")
    found.add_argument("--driver", default="idm-yield")
    usual = ["always-go", "learned", "gap-acceptance"]
    words = "names, perhaps with a world (campus@campus); the first one is compared with the others"
    found.add_argument("--pedestrians", nargs="*", default=usual, help=words)
    found.add_argument("--episodes", type=int, default=EPISODES)
    return found


def main() -> None:
    """Measure, and write results.json and results.md."""
    command = options()
    asked = command.parse_args()
    if asked.episodes < 1:
        command.error(f"--episodes must be at least 1, not {asked.episodes}")
    try:
        people = cast(asked.driver, asked.pedestrians)
        grounds = read_clip_grounds(asked.ground)
        fit, test = halves(grounds)
        clips = {"all": sorted(grounds.clips), "fit": fit, "test": test}[asked.clips]
        real = watch_clips(asked.folder, grounds, clips)
    except (TracksError, ContestantError, MixtureError, RunError) as error:
        command.error(str(error))
    ours = {name: watch_ours(asked.driver, *who, asked.episodes) for name, who in people.items()}
    away = distances(real, ours)
    settings = {"clips": clips, "driver": asked.driver, "episodes": asked.episodes}
    document = {
        "made": asdict(provenance()),
        "settings": settings | {"people": PEOPLE, "seed": SEED, "top_speed": TOP_SPEED},
        "real": describe(real),
        "ours": {name: describe(watched) for name, watched in ours.items()},
        "distances": {
            name: {who: asdict(estimated(draws)) for who, draws in by_population.items()}
            for name, by_population in away.items()
        },
        "nearer": {name: compared(by_population) for name, by_population in away.items()},
    }
    asked.out.mkdir(parents=True, exist_ok=True)
    write_whole(asked.out / "results.json", json.dumps(document, indent=1, allow_nan=False) + "\n")
    write_whole(asked.out / "results.md", tables(document))
    print(tables(document))


if __name__ == "__main__":
    main()
