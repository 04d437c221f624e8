"""One episode, played as it was when it was written down.

If people or cars are meant to move differently from now on, write it down anew, and look at the difference:

    .venv/bin/python tests/golden/test_golden.py
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1]))

from sim.play import ENVIRONMENTS, PEOPLE, STEPS, play

FILE = Path(__file__).parent / "street.json"
ENV, EVERY = 5, 10


def scripted():
    """Throttle and brakes by turns, a little steering to both sides; each pedestrian waits 2 of every 7 to 18 s."""
    t = np.arange(STEPS)[:, None]
    drive = np.stack([np.where(t % 120 < 90, 0.4, -1.0), 0.15 * np.sin(t / 9)], axis=1)
    period = 70 + 10 * np.arange(PEOPLE)
    go = (t % period >= 20).astype(np.int32)[..., None]
    shape = (STEPS, -1, ENVIRONMENTS)
    return (np.broadcast_to(drive, (STEPS, 2, ENVIRONMENTS)).astype(np.float32),
            np.broadcast_to(go, (STEPS, PEOPLE, ENVIRONMENTS)).reshape(shape))  # fmt: skip


def record(street, scenarios):
    """What the file holds: the scenario, and every tenth frame."""
    played = play(street, scenarios, *scripted())
    frames = {name: np.asarray(x)[::EVERY, ..., ENV] for name, x in played.items()}
    return {
        "scenario": {
            name: np.asarray(getattr(scenarios, name))[..., ENV].tolist()
            for name in ("map", "route", "start", "goals", "traits")
        },
        "car": {name: numbers(frames[f"car_{name}"]) for name in ("x", "y", "speed")},
        "people": [
            {name: numbers(frames[name][:, p]) for name in ("x", "y", "crossing", "goal")} for p in range(PEOPLE)
        ],
    }


def numbers(x):
    return [round(float(v), 4) if x.dtype.kind == "f" else int(v) for v in x]


def test_the_episode_of_the_file_is_played(street, scenarios):
    expected, found = json.loads(FILE.read_text()), record(street, scenarios)
    for name, value in expected["scenario"].items():
        np.testing.assert_allclose(found["scenario"][name], value, atol=1e-6, err_msg=f"scenario: {name}")
    for name in expected["car"]:
        np.testing.assert_allclose(found["car"][name], expected["car"][name], atol=1e-3, err_msg=f"car: {name}")
    for p, (one, other) in enumerate(zip(found["people"], expected["people"], strict=True)):
        for name in other:
            np.testing.assert_allclose(one[name], other[name], atol=1e-3, err_msg=f"pedestrian {p}: {name}")
    assert {kind for one in expected["people"] for kind in one["crossing"]} == {0, 1, 2}  # it shows what it should


def main():
    from jaxwalk import Street
    from sim.play import draw

    street = Street.create()
    found = record(street, draw(street, 1, 0, 0))
    rows = lambda table: ",\n    ".join(f"{json.dumps(name)}: {json.dumps(x)}" for name, x in table.items())  # noqa: E731
    people = ",\n".join(f"  {{\n    {rows(one)}\n  }}" for one in found["people"])
    FILE.write_text(
        f'{{\n"every": {EVERY},\n"scenario": {{\n    {rows(found["scenario"])}\n}},\n'
        f'"car": {{\n    {rows(found["car"])}\n}},\n"people": [\n{people}\n]\n}}\n'
    )


if __name__ == "__main__":
    main()
