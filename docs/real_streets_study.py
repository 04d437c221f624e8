"""The study of docs/real-streets.md: what becomes of the crossings and pavements of maps, and what an import takes.

    python docs/real_streets_study.py town.osm net.net.xml map.osm road.xodr --out runs/real-streets

Each file is imported in a process of its own, whose time and memory are measured, into tiles in a folder beneath --out.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from jaxwalk.evaluation import evaluate
from jaxwalk.evaluation.playing import play
from jaxwalk.maps import each_map
from jaxwalk.maps.map_reading import map_name
from jaxwalk.metrics import OUTCOMES
from jaxwalk.policies import AlwaysGo, Oracle, RouteFollower
from jaxwalk.provenance import provenance
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.environment import Street
from jaxwalk.writing import write_whole

SEED, BATCH = 29, 256
GOOD = 0.95
"""The oracle is to arrive on at least this share of the scenarios of a tile."""
IMPORT = """
import pathlib, re, sys, time
begun = time.perf_counter()
from jaxwalk.cli import main
code = main()
seconds = time.perf_counter() - begun
try:
    peak = 1024 * int(re.search(r"VmHWM:\\s*(\\d+)", pathlib.Path("/proc/self/status").read_text())[1])
except OSError:  # not Linux
    import resource
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(f"{seconds} {peak}")
sys.exit(code)
"""
"""Imports as the command does, and then prints its seconds and its peak memory in bytes."""


def imported(file: Path, folder: Path) -> dict[str, Any]:
    """Import a file into a folder of tiles, and return what that took, or why it is refused."""
    command = [sys.executable, "-c", IMPORT, "import", str(file), "--out", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        said = [line for line in done.stderr.splitlines() if line.startswith("jaxwalk: ")]
        return {"refused": (said or done.stderr.strip().splitlines() or ["no message"])[-1]}
    seconds, peak = map(float, done.stdout.splitlines()[-1].split())
    return {"seconds": round(seconds, 1), "peak_MB": round(peak / 1e6)}


def described(folder: Path) -> dict[str, Any]:
    """Return what the report of an import says of crossings, pavement and tiles."""
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    tiles, crossings = report["streets"], report["crossings"]
    usable = [tile["pavement"] for tile in tiles if tile["verdict"] != "not usable"]
    known = sum(x["mapped"] + x["inferred"] for x in usable)
    before = sum((x["mapped"] + x["inferred"]) * x["largest_before"] for x in usable)
    return {
        "format": report["format"],
        "attribution": report["attribution"],
        "crossings": len(crossings),
        "placed": sum(x["placed"] for x in crossings),
        "farthest_moved": max((x["moved"] for x in crossings if x["placed"]), default=0.0),
        "reasons": dict(Counter(x["reason"] for x in crossings if not x["placed"])),
        "elsewhere": report["elsewhere"],
        "tiles": len(tiles),
        "usable": len(usable),
        "known_m": round(known),
        "connected_before": round(before / known, 3) if known else None,
        "connected_after": round(sum(x["kept"] for x in usable) / known, 3) if known else None,
    }


def loaded(folder: Path) -> dict[str, float]:
    """Return how long a tile takes to load as a street [s]: in the middle and at most, once another street has been."""
    names = each_map([str(folder)])
    Street.create()
    seconds = []
    for name in names:
        begun = time.perf_counter()
        Street.create((name,))
        seconds.append(time.perf_counter() - begun)
    return {"load_s": round(float(np.median(seconds)), 2), "longest_load_s": round(max(seconds), 2)}


def driven(folder: Path, episodes: int) -> dict[str, Any]:
    """Return on which share of drawn scenarios the oracle arrives, in all and on each tile."""
    names = each_map([str(folder)])
    street = Street.create(names)
    policies = {"driver": Oracle(), "pedestrian": AlwaysGo()}
    rows = evaluate(street, policies, Drawn(street, SEED, min(episodes * len(names), 16384)), batch=BATCH)
    goal = rows[OUTCOMES].goal
    maps = np.full(len(goal), map_name(names[0])) if rows.maps is None else rows.maps
    shares = {name: round(float(goal[maps == name].mean()), 3) for name in sorted(set(maps.tolist()))}
    return {"episodes": len(goal), "arrives": round(float(goal.mean()), 3), "by_tile": shares,
            "good_tiles": sum(share >= GOOD for share in shares.values())}  # fmt: skip


def walked(folder: Path, episodes: int) -> dict[str, int]:
    """Return how many frames of people there are on a roadway without jaywalks, and how many off a crosswalk."""
    names = each_map([str(folder)])
    street = Street.create(names, jaywalk_multiplier=0.0)
    drawn, policies = Drawn(street, SEED), {"driver": RouteFollower(), "pedestrian": AlwaysGo()}
    crossing = off = 0
    for first in range(0, min(episodes * len(names), 16384), BATCH):
        played = play(street, policies, *drawn.take(np.arange(first, first + BATCH)))
        crossing += int(played.on_roadway.sum())
        off += int((played.on_roadway & ~played.on_crosswalk).sum())
    return {"frames_on_roadways": crossing, "off_crosswalks": off}


def measured(file: Path, folder: Path, episodes: int) -> dict[str, Any]:
    """Return all that is measured of a file."""
    found = {"file": file.name, **imported(file, folder)}
    if "refused" in found:
        return found
    found |= described(folder)
    if found["usable"]:
        found |= loaded(folder) | (driven(folder, episodes) | walked(folder, episodes) if episodes else {})
    return found


def table(rows: list[dict[str, Any]]) -> str:
    """Return the results as a table in Markdown."""
    lines = [
        "| file | crossings used | pavement in one part before, after | tiles usable | seconds, MB | "
        "a tile loads in [s] | the oracle arrives | tiles with 95 % |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for row in rows:
        if "refused" in row:
            lines.append(f"| {row['file']} | {row['refused']} |" + " |" * 6)
            continue
        pavement = "none mapped" if row["connected_before"] is None else \
            f"{row['connected_before']:.0%}, {row['connected_after']:.0%} of {row['known_m']:,} m"  # fmt: skip
        load = f"{row['load_s']}, at most {row['longest_load_s']}" if "load_s" in row else ""
        oracle = f"{row['arrives']:.1%} of {row['episodes']:,}" if "arrives" in row else ""
        good = f"{row['good_tiles']} of {len(row['by_tile'])}" if "arrives" in row else ""
        cells = (
            row["file"], f"{row['placed']} of {row['crossings']}", pavement, f"{row['usable']} of {row['tiles']}",
            f"{row['seconds']}, {row['peak_MB']}", load, oracle, good,
        )  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure each file, and write a table and all numbers."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    options.add_argument("files", nargs="+", type=Path)
    options.add_argument(
        "--episodes", type=int, default=64, help="scenarios a tile for the oracle; 0: it doesn't drive"
    )
    options.add_argument("--out", type=Path, default=Path("runs/real-streets"))
    asked = options.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    rows: list[dict[str, Any]] = []
    for file in asked.files:
        rows.append(measured(file, asked.out / file.name.split(".")[0], asked.episodes))
        print(json.dumps({name: value for name, value in rows[-1].items() if name != "by_tile"}), flush=True)
        document = {"made": asdict(provenance()), "seed": SEED, "episodes_a_tile": asked.episodes, "files": rows}
        write_whole(asked.out / "results.json", json.dumps(document, indent=1) + "\n")
        write_whole(asked.out / "results.md", table(rows))
    print(table(rows))


if __name__ == "__main__":
    main()
