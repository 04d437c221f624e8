"""The study of docs/real-recordings.md: what real people and cars do at a crosswalk, and what ours do, measured alike.

    python docs/real_recordings_study.py FOLDER --out runs/real-recordings

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
from jaxwalk.experiments.real_recordings import Watched, describe, distances, watch_clips, watch_episodes
from jaxwalk.formats.areas import areas_of, parse_areas
from jaxwalk.formats.clip_grounds import read_clip_grounds
from jaxwalk.formats.tracks import TracksError
from jaxwalk.maps import as_network
from jaxwalk.metrics.statistics import Estimate, interval
from jaxwalk.provenance import provenance
from jaxwalk.policies.mixture_names import MixtureError
from jaxwalk.runs.contestant_names import ContestantError, check_name
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.folder import RunError
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.sim.sim_config import WORLDS
from jaxwalk.writing import write_whole

GROUND = Path(__file__).with_name("dut_ground.toml")
TOP_SPEED = 2.7
"""The car's top speed on our street [m/s]: real cars that move are slower three quarters of their time."""
PEOPLE, EPISODES, SEED = 36, 64, 77
LINES = {
    "waited": ("stopped before the car's path", 100.0, "%"),
    "pedestrian_first": ("person came first", 100.0, "%"),
    "accepted": ("accepted gap, median", 1.0, "s"),
    "crossing_speed": ("crossing speed, median", 1.0, "m/s"),
    "pet": ("post-encroachment time, median", 1.0, "s"),
    "min_distance": ("smallest distance, median", 1.0, "m"),
}


def watch_ours(driver: str, populations: list[str], episodes: int) -> dict[str, Watched]:
    """Return our people, on the paper's street with slow cars."""
    street = Street.create(config=replace(WORLDS["paper-footprint"], max_speed=TOP_SPEED, pedestrians=PEOPLE))
    areas = parse_areas(areas_of(as_network(street.maps[0])), "the paper's street")
    scenarios, keys = Drawn(street, seed=SEED, count=episodes).take(np.arange(episodes))
    car = contestant(street, "driver", driver)
    found = {}
    for name in populations:
        people = contestant(street, "pedestrian", name)
        trajectory = play(street, {"driver": car, "pedestrian": people}, scenarios, keys)
        found[name] = watch_episodes(trajectory, areas, street.config)
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
    lines += [
        "",
        "| Wasserstein-1 from real | " + " | ".join(document["ours"]) + " |",
        "| --- " * (1 + len(document["ours"])) + "|",
    ]
    for name, by_population in document["distances"].items():
        words, scale, unit = LINES[name]
        row = [written(number, scale) for number in by_population.values()]
        lines.append(f"| {words.removesuffix(', median')}, {unit} | " + " | ".join(row) + " |")
    return "\n".join(lines) + "\n"


def estimated(draws: np.ndarray) -> Estimate:
    """Return a number with its interval over recordings."""
    return interval(draws, len(draws) - 1)


def main() -> None:
    """Measure, and write results.json and results.md."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    options.add_argument("folder", type=Path, help="the clips, which are no part of jaxwalk")
    options.add_argument("--ground", type=Path, default=GROUND, help="areas of the clips, as docs/dut_ground.toml")
    options.add_argument("--out", type=Path, default=Path("runs/real-recordings"))
    options.add_argument("--driver", default="idm-yield")
    options.add_argument("--pedestrians", nargs="*", default=["always-go", "learned", "gap-acceptance"])
    options.add_argument("--episodes", type=int, default=EPISODES)
    asked = options.parse_args()
    if asked.episodes < 1:
        options.error(f"--episodes must be at least 1, not {asked.episodes}")
    try:
        for role, names in (("driver", [asked.driver]), ("pedestrian", asked.pedestrians)):
            for name in names:
                check_name(role, name)
        grounds = read_clip_grounds(asked.ground)
        real = watch_clips(asked.folder, grounds, sorted(grounds.clips))
    except (TracksError, ContestantError, MixtureError, RunError) as error:
        options.error(str(error))
    ours = watch_ours(asked.driver, asked.pedestrians, asked.episodes)
    document = {
        "made": asdict(provenance()),
        "settings": {
            "driver": asked.driver, "episodes": asked.episodes, "people": PEOPLE, "seed": SEED, "top_speed": TOP_SPEED
        },
        "real": describe(real),
        "ours": {name: describe(watched) for name, watched in ours.items()},
        "distances": {
            name: {who: asdict(estimated(draws)) for who, draws in by_population.items()}
            for name, by_population in distances(real, ours).items()
        },
    }  # fmt: skip
    asked.out.mkdir(parents=True, exist_ok=True)
    write_whole(asked.out / "results.json", json.dumps(document, indent=1, allow_nan=False) + "\n")
    write_whole(asked.out / "results.md", tables(document))
    print(tables(document))


if __name__ == "__main__":
    main()
