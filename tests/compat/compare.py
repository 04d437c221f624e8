"""Compare how this jaxwalk behaves with what was recorded of version 0.1 at commit ee64c7f.

    .venv/bin/python tests/compat/compare.py                      # everything: half an hour on two cores
    .venv/bin/python tests/compat/compare.py --quick              # a slice of each part
    .venv/bin/python tests/compat/compare.py scenarios updates    # some parts
    .venv/bin/python tests/compat/compare.py --record all "paper co-trained on 1"   # what is meant to change, again

Prints a line for each comparison and exits with 1 if any of them differs:

- scenarios: their hashes are equal;
- evaluations: of a cell's outcomes at most one in 2,000 differs, and every number of the JSON document agrees within
  1e-4, absolute below 1 and relative above (within 1e-2 in a cell of which an outcome differs);
- updates: every metric of the first three updates agrees within 1 %, absolute below 0.01;
- trained: the policy file and the run folder of 0.1 play as they did, and its checkpoint can be resumed or is refused
  in one sentence.

`driver_ms_per_step` is a time and is not compared, nor is what was given another definition since (`REDEFINED`). Names
that were added since are allowed.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from compat.fast_of_0_1 import fast_of_0_1
from compat.record import (
    EVALUATIONS,
    PARTS,
    QUICK_TO_COMPILE,
    SCENARIOS,
    TRAININGS,
    CommandError,
    evaluation,
    evaluation_file,
    jaxwalk,
    metrics,
    play_trained,
    read,
    resume_trained,
    scenario_hash,
    updates_file,
    write,
)  # fmt: skip
from jaxwalk.recipes import RECIPES, single_agent, with_training
from jaxwalk.runs.folder import Run

RECORDED = Path(__file__).parent / "recorded"
TRAINED = RECORDED / "trained"
NUMBERS, METRICS, AFTER_ONE = 1e-4, 1e-2, 1e-2
"""Tolerances of the document, of training metrics, and of the document's cell in which an outcome differs."""
MOST_OUTCOMES = 1 / 2000
"""Share of a cell's outcomes that may differ; one always may."""
REDEFINED = {"schema", "low", "high", "surrogates", "surrogate_distributions"}
"""Names in the document: intervals cover now, and surrogate safety is by the car's footprint (docs/migrating.md)."""
OF_0_1 = {name: f"{name}-0.1" for name in ("co-trained", "single-agent", "learned")}
"""What the policies that 0.1 shipped are called now."""
QUICK = {"scenarios": SCENARIOS[1:2], "evaluations": ("quick",), "updates": tuple(TRAININGS)[:1]}
FULL = {"scenarios": SCENARIOS, "evaluations": tuple(EVALUATIONS), "updates": tuple(TRAININGS)}


@dataclass(frozen=True)
class Compared:
    """One comparison."""

    what: str
    differs: str = ""
    """What differs; empty if nothing does."""
    note: str = ""
    skipped: bool = False
    """Nothing was recorded to compare with."""


def compare_scenarios(sets, *, folder: Path) -> Iterator[Compared]:
    """Hashes of scenario sets."""
    recorded = {tuple(chosen): found for *chosen, found in read(RECORDED / "scenarios.json.gz")}
    for chosen in sets:
        seed, episodes, multiplier = chosen
        found = scenario_hash(*chosen, folder=folder)
        differs = "" if found == recorded[chosen] else f"hash {found}, not {recorded[chosen]}"
        yield Compared(f"scenarios: {episodes} of seed {seed}, multiplier {multiplier:g}", differs, found)


def compare_evaluation(name: str, *, folder: Path) -> Iterator[Compared]:
    """Outcomes and numbers of each cell of an evaluation."""
    before, now = read(evaluation_file(RECORDED, name)), evaluation_with_0_1(EVALUATIONS[name], folder=folder)
    outside = [lasting({**x["document"], "cells": len(x["document"]["cells"])}) for x in (before, now)]
    yield Compared(f"evaluation {name}: scenarios and number of cells", shown(differences(*outside, NUMBERS)))
    changed = {}
    for cell, letters in before["outcomes"].items():
        differs, changed[cell] = different_outcomes(letters, now["outcomes"].get(cell, ""))
        yield Compared(f"evaluation {name}: outcomes of {cell}", differs, f"{changed[cell]} of {len(letters)} differ")
    pairs = zip(lasting(before["document"]["cells"]), now["document"]["cells"], changed.values(), strict=False)
    for old, new, count in pairs:
        cell = f"{old['driver']} among {old['pedestrians']}, multiplier {old['jaywalk_multiplier']:g}"
        differs = differences(old, new, AFTER_ONE if count else NUMBERS)
        yield Compared(f"evaluation {name}: numbers of {cell}", shown(differs), f"{count_numbers(old)} numbers")


def evaluation_with_0_1(options: dict[str, tuple], *, folder: Path) -> dict:
    """Evaluate the policies that 0.1 shipped, and call them as 0.1 did."""
    chosen = {option: tuple(OF_0_1.get(value, value) for value in values) for option, values in options.items()}
    text = json.dumps(evaluation(chosen, folder=folder))
    for then, now in OF_0_1.items():
        text = text.replace(now, then)
    return json.loads(text)


def record_again(name: str, *, folder: Path) -> None:
    """Record a training again, or an evaluation: of its document, the parts that 0.1 had."""
    if name in TRAININGS:
        write(updates_file(RECORDED, name), updates_of_0_1(name, folder=folder))
        return
    found = evaluation_with_0_1(EVALUATIONS[name], folder=folder)
    found["document"] = {part: found["document"][part] for part in ("schema", "scenarios", "cells")}
    write(evaluation_file(RECORDED, name), found)


def lasting(part):
    """The part of a document without what was given another definition since."""
    if isinstance(part, dict):
        return {name: lasting(x) for name, x in part.items() if name not in REDEFINED}
    return [lasting(x) for x in part] if isinstance(part, list) else part


def different_outcomes(before: str, now: str) -> tuple[str, int]:
    """What is wrong with the outcomes of a cell, and how many differ."""
    if len(before) != len(now):
        return f"{len(now)} outcomes, not {len(before)}", len(before)
    where = [i for i, pair in enumerate(zip(before, now, strict=True)) if pair[0] != pair[1]]
    many = len(where) > max(1, MOST_OUTCOMES * len(before))
    return (f"{len(where)} of {len(before)} outcomes, first in scenario {where[0]}" if many else ""), len(where)


def compare_updates(name: str, *, folder: Path) -> Iterator[Compared]:
    """Metrics of the first updates of a training."""
    before = read(updates_file(RECORDED, name))
    yield Compared(f"updates: {name}", *metrics_differ(before, updates_of_0_1(name, folder=folder)))


def updates_of_0_1(name: str, *, folder: Path) -> list[dict]:
    """Train with 0.1's recipe, whose options are `TRAININGS`, and return the lines of metrics.jsonl."""
    recipe, kind, _, shards = name.split()
    experiment = fast_of_0_1() if recipe == "fast" else RECIPES[recipe]
    experiment = single_agent(experiment) if kind == "single-agent" else experiment
    sizes = {"environments": 48, "steps": 128, "minibatches": 4, "updates": 3}
    run = Run.create(Path(tempfile.mkdtemp(dir=folder)) / "run", with_training(experiment, shards=int(shards), **sizes))
    jaxwalk("train", "--resume", run.path, folder=folder, flags=QUICK_TO_COMPILE)
    return metrics(run.path)


def metrics_differ(before: list[dict], now: list[dict]) -> tuple[str, str]:
    """What is wrong with lines of metrics, and the largest difference."""
    floor = 0.01  # a metric around 0, such as a mean advantage, has no relative difference
    return shown(differences(before, now, METRICS, floor=floor)), f"{count_numbers(before)} numbers"


def compare_trained(*, folder: Path) -> Iterator[Compared]:
    """The run folder of 0.1: it plays and resumes."""
    recorded = read(RECORDED / "trained.json.gz")
    try:
        found = play_trained(TRAINED, folder=folder)
        for name, before in recorded["outcomes"].items():
            differs, count = different_outcomes(before, found[name])
            yield Compared(f"trained: {name} of 0.1 plays", differs, f"{count} of {len(before)} outcomes differ")
    except CommandError as error:
        yield Compared("trained: policy file and run folder of 0.1 play", str(error))
    try:
        differs, note = metrics_differ(recorded["resumed"], resume_trained(TRAINED, folder=folder))
    except CommandError as error:
        differs, note = ("" if refused(error) else str(error)), f"refused: {error}"
    yield Compared("trained: checkpoint of 0.1 resumes", differs, note)


def refused(error: CommandError) -> bool:
    """Whether a command failed with one line that names the checkpoint, after warnings that the folder is old."""
    text = str(error)
    (said, *more) = [line for line in text.splitlines() if line.startswith("jaxwalk: ")] or [""]
    return "Traceback" not in text and not more and "checkpoint" in said


def differences(before, now, tolerance: float, *, floor: float = 1.0) -> list[str]:
    """Where two documents differ: a number by more than the tolerance times its size, or times the floor if larger."""
    return [f"{where or 'it'} {what}" for where, what in _differences(before, now, tolerance, floor)]


def _differences(before, now, tolerance: float, floor: float) -> Iterator[tuple[str, str]]:
    """The places in the documents, and what is wrong there."""
    if isinstance(before, dict) and isinstance(now, dict):
        before, now = ({x: y for x, y in d.items() if x != "driver_ms_per_step"} for d in (before, now))
        yield from ((f".{name}", "is missing") for name in before if name not in now)
        pairs = {f".{name}": (x, now[name]) for name, x in before.items() if name in now}
    elif isinstance(before, list) and isinstance(now, list):
        if len(before) != len(now):
            yield "", f"has {len(now)} entries, not {len(before)}"
        pairs = {f"[{i}]": pair for i, pair in enumerate(zip(before, now, strict=False))}
    else:
        numbers = is_number(before) and is_number(now)
        if not (abs(before - now) <= tolerance * max(floor, abs(before)) if numbers else before == now):
            yield "", f"is {now!r}, not {before!r}"
        return
    for name, (x, y) in pairs.items():
        yield from ((name + where, what) for where, what in _differences(x, y, tolerance, floor))


def is_number(x) -> bool:
    return isinstance(x, int | float) and not isinstance(x, bool)


def count_numbers(document) -> int:
    """How many numbers a document holds."""
    if isinstance(document, dict):
        return sum(map(count_numbers, document.values()))
    if isinstance(document, list):
        return sum(map(count_numbers, document))
    return int(is_number(document))


def shown(differs: list[str]) -> str:
    """The first differences, and how many there are."""
    return f"{len(differs)} differ: " + "; ".join(x.lstrip(".") for x in differs[:4]) if differs else ""


def compare(parts, *, quick: bool, folder: Path) -> Iterator[Compared]:
    """Compare part after part."""
    chosen = QUICK if quick else FULL
    if "scenarios" in parts:
        yield from compare_scenarios(chosen["scenarios"], folder=folder)
    if "trained" in parts:
        yield from compare_trained(folder=folder)
    for name in chosen["updates"] if "updates" in parts else ():
        compared = compare_updates(name, folder=folder)
        yield from guarded(f"updates: {name}", updates_file(RECORDED, name), compared)
    for name in chosen["evaluations"] if "evaluations" in parts else ():
        compared = compare_evaluation(name, folder=folder)
        yield from guarded(f"evaluation {name}", evaluation_file(RECORDED, name), compared)


def guarded(what: str, recorded: Path, compared: Iterator[Compared]) -> Iterator[Compared]:
    """The comparisons, if there is anything to compare with; a command that fails is a difference."""
    if not recorded.exists():
        yield Compared(what, note="not recorded at ee64c7f, so not compared", skipped=True)
        return
    try:
        yield from compared
    except CommandError as error:
        yield Compared(what, str(error))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", help=", ".join(PARTS))
    parser.add_argument("--quick", action="store_true", help="a slice of each part")
    again = {"nargs": "+", "choices": (*EVALUATIONS, *TRAININGS), "metavar": "NAME", "default": []}
    parser.add_argument("--record", **again, help="record again: " + ", ".join((*EVALUATIONS, *TRAININGS)))
    options = parser.parse_args()
    different = 0
    with tempfile.TemporaryDirectory(prefix="jaxwalk-compare-") as scratch:
        for name in options.record:
            record_again(name, folder=Path(scratch))
        if options.record:
            return 0
        for found in compare(options.parts or PARTS, quick=options.quick, folder=Path(scratch)):
            different += bool(found.differs)
            mark = "DIFFERS" if found.differs else "skipped" if found.skipped else "same"
            print(f"{mark:<8}{found.what:<78} {found.differs or found.note}", flush=True)
    print(f"{different} comparisons differ from commit ee64c7f" if different else "No difference from commit ee64c7f")
    return int(different > 0)


if __name__ == "__main__":
    raise SystemExit(main())
