"""The calibration of docs/real-recordings.md: people and the speed of cars, fitted to one half of the clips.

    python docs/real_recordings_calibration.py FOLDER --out runs/calibration

FOLDER: as for docs/real_recordings_study.py, which tests the result on the other half.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from jaxwalk.experiments.people_calibration import car_speed, fit_people
from jaxwalk.experiments.real_recordings import halves, watch_clips
from jaxwalk.formats.clip_grounds import read_clip_grounds
from jaxwalk.formats.tracks import TracksError
from jaxwalk.provenance import provenance
from jaxwalk.writing import write_whole

GROUND = Path(__file__).with_name("dut_ground.toml")
LINES = {
    "intercept": "gap acceptance: intercept",
    "per_second": "gap acceptance: per second, 1/s",
    "critical": "gap that one half accept, s",
    "slowest": "slowest pace, m/s",
    "fastest": "fastest pace, m/s",
}


def main() -> None:
    """Fit, and write calibration.json."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    options.add_argument("folder", type=Path, help="the clips, which are no part of jaxwalk")
    options.add_argument("--ground", type=Path, default=GROUND, help="areas of the clips, as docs/dut_ground.toml")
    options.add_argument("--out", type=Path, default=Path("runs/calibration"))
    asked = options.parse_args()
    try:
        grounds = read_clip_grounds(asked.ground)
        names, _ = halves(grounds)
        people = fit_people(watch_clips(asked.folder, grounds, names))
        speed = car_speed(asked.folder, grounds, names)
    except TracksError as error:
        options.error(str(error))
    document = {"made": asdict(provenance()), "clips": names, "people": people, "car_speed": speed}
    asked.out.mkdir(parents=True, exist_ok=True)
    write_whole(asked.out / "calibration.json", json.dumps(document, indent=1, allow_nan=False) + "\n")
    print(f"{len(names)} clips, {people['meetings']} meetings; {people['judged']} with a car to judge, of which")
    print(f"{people['accepted']} came first. Cars that move are slower than {speed:.2f} m/s for 3/4 of their time.")
    for name, words in LINES.items():
        value, low, high = (people[name][part] for part in ("value", "low", "high"))
        ends = "undefined" if low is None else f"{low:.2f}, {high:.2f}"
        print(f"{words}: {value:.2f} [{ends}]")
    seen = people["approach_seen"]
    curve = " ".join("undefined" if seen[name] is None else f"{seen[name]:.2f}" for name in list(LINES)[:3])
    print(f"of the {seen['judged']} in view before they judge, {seen['accepted']} came first; the same three: {curve}")


if __name__ == "__main__":
    main()
