"""What a program compiled for a GPU launches, copies and waits for, read from the files that XLA dumps of it.

``thunk_sequence.txt`` has what is launched, nested as it runs; ``thunk_metadata.txt`` the instruction behind each; the
optimised program the trip counts of loops, the source of each instruction, and XLA's model of the time it takes.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

LAUNCHES, COPIES, SYNCHRONISATIONS, MICROSECONDS = "launches", "copies", "synchronisations", "microseconds"
"""What is counted. Copies are launches too. A synchronisation makes the host wait for the GPU."""
PARTS = ("draw", "reset", "observe", "global_state", "step")
"""The parts of a simulation: methods of the street, each compiled under its own name."""
REST = "rest"
"""What belongs to none of them: copies that loops need, acting, learning."""
NO_LAUNCH = ("kAsyncStart", "kAsyncDone", "kSequential", "kDynamicSliceFusion")
"""Kinds of entry that launch nothing besides what they contain."""

Work = Counter[tuple[str, str]]
"""Amounts, by what is counted and by the part of the simulation that it belongs to."""


class ThunkError(ValueError):
    """XLA's files are not as expected: another release writes them otherwise. The message names the file."""


class Instruction(NamedTuple):
    """An instruction of the optimised program."""

    trips: int | None
    """Number of turns, of a loop for which it is known when compiling."""
    microseconds: float
    """Time by XLA's model, without what a launch costs."""
    part: str


@dataclass
class Thunk:
    """An entry of the sequence."""

    kind: str
    instruction: Instruction
    label: str = ""
    """Which branch or part of a loop of the entry above it belongs to: ``condition:``, ``body:``, ..."""
    inside: list[Thunk] = field(default_factory=list)


NOTHING = Instruction(None, 0.0, REST)
"""Stands for an instruction that the files don't name."""


def read_work(folder: Path, passes: int = 1) -> Work:
    """Return all that a program does in one call, from the folder into which XLA dumped it.

    Data-dependent loops count as ``passes`` turns, and of the branches of a condition the one with most launches
    counts. Raise ThunkError if a file is missing, or none of it can be read.
    """
    instructions = dict(_instructions(_text(folder, "gpu_after_optimizations.txt")))
    pairs = re.findall(r'profile_annotation: "([^"]*)"\s+thunk_id: (\d+)', _text(folder, "thunk_metadata.txt"))
    names = {int(number): name for name, number in pairs}
    sequence = _text(folder, "thunk_sequence.txt")
    work = _together(_nested(sequence, {n: instructions.get(name, NOTHING) for n, name in names.items()}), passes)
    if not total(work, LAUNCHES):
        raise ThunkError(f"{folder}: no launch in the files of this release of XLA; take the release in requirements/")
    return work


def total(work: Work, what: str) -> float:
    """Return the amount in all parts together."""
    return sum((amount for (counted, _), amount in work.items() if counted == what), 0.0)


def by_part(work: Work, what: str) -> dict[str, float]:
    """Return the amount in each part that has any."""
    return {part: float(work[what, part]) for part in (*PARTS, REST) if work[what, part]}


def _text(folder: Path, ending: str) -> str:
    found = sorted(folder.glob(f"*{ending}"))
    if len(found) != 1:
        raise ThunkError(f"{folder}: {len(found)} files *{ending}, not one; take the release of JAX in requirements/")
    return found[0].read_text(encoding="utf-8", errors="replace")


def _instructions(program: str) -> Iterator[tuple[str, Instruction]]:
    """Yield name and content of each instruction of an optimised program."""
    for line in program.splitlines():
        named = re.match(r"\s+(?:ROOT )?%?([\w.\-]+) = ", line)
        if not named:
            continue
        trips = re.search(r'known_trip_count":\{"n":"(\d+)"', line)
        time = re.search(r'"exec_time_us":([\d.e+-]+)', line)
        source = re.search(r'op_name="([^"]*)"', line)
        parts = [x for x in re.findall(r"jit\((\w+)\)", source[1]) if x in PARTS] if source else []
        yield (
            named[1],
            Instruction(
                int(trips[1]) if trips else None, float(time[1]) if time else 0.0, parts[-1] if parts else REST
            ),
        )


def _nested(sequence: str, instructions: Mapping[int, Instruction]) -> list[Thunk]:
    """Return the entries of a sequence: deeper ones are indented by four columns more, below a label."""
    root = Thunk("root", NOTHING)
    path, labels, label = [root], dict[int, str](), ""
    for line in sequence.splitlines():
        entry = re.match(r"( *)(\d+): (k\w+)", line)
        if not entry:
            label = line.strip() or label
            continue
        depth = len(entry[1]) // 4
        if label:
            labels[depth], label = label, ""
        thunk = Thunk(entry[3], instructions.get(int(entry[2]), NOTHING), labels.get(depth, "") if depth else "")
        path = [*path[: depth + 1], thunk]
        path[-2].inside.append(thunk)
    return root.inside


def _together(thunks: list[Thunk], passes: int) -> Work:
    work = Work()
    for thunk in thunks:
        work.update(_work(thunk, passes))
    return work


def _work(thunk: Thunk, passes: int) -> Work:
    instruction = thunk.instruction
    if thunk.kind == "kWhile":
        return _loop(thunk, passes)
    if thunk.kind == "kConditional":
        branches = [
            _together([x for x in thunk.inside if x.label == label], passes)
            for label in {x.label for x in thunk.inside}
        ]
        longest = max(branches, key=lambda branch: total(branch, LAUNCHES), default=Work())
        return longest + Work({(SYNCHRONISATIONS, instruction.part): 1})
    if thunk.inside or thunk.kind in NO_LAUNCH:
        return _together(thunk.inside, passes)
    one = Work({(LAUNCHES, instruction.part): 1})
    one[MICROSECONDS, instruction.part] = instruction.microseconds  # pyright: ignore[reportArgumentType]
    one[COPIES, instruction.part] += thunk.kind == "kCopy"
    return one


def _loop(thunk: Thunk, passes: int) -> Work:
    """Return the work of a loop. Where its number of turns is known, the condition isn't computed on the GPU."""
    turns = thunk.instruction.trips
    body = _together([x for x in thunk.inside if x.label != "condition:"], passes)
    if turns is not None:
        return _times(body, turns)
    condition = _together([x for x in thunk.inside if x.label == "condition:"], passes)
    condition[SYNCHRONISATIONS, thunk.instruction.part] += 1
    return _times(body, passes) + _times(condition, passes + 1)


def _times(work: Work, count: int) -> Work:
    return Work({key: count * amount for key, amount in work.items()})
