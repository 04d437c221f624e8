"""What is done to the words of a command line before tyro reads them.

tyro keeps only the last of an option's repetitions, and says nothing about the others.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any, get_args, get_origin, get_type_hints

from jaxwalk.cli.errors import UsageError

RENAMED = {
    "evaluate": {"sample_driver": "--driver-acts sample", "pedestrian_mode": "--pedestrians-act mode"},
}
"""For each command: options of earlier versions, and what to write instead."""


def gathered(command: str, kind: type, words: Sequence[str]) -> list[str]:
    """Return the words with all values of a repeated option at its first place.

    Args:
        command: the name of the command.
        kind: the class of its options.
        words: the words after the command's name.

    Raises:
        UsageError: an option that takes one value is repeated, an option has another name now, or ``--driver`` stands
            before drivers that need no option.
    """
    options, renamed = dict(_options(kind)), RENAMED.get(command, {})
    if (
        "--driver" in (word.partition("=")[0] for word in words)
        and "driver" not in options
        and options.keys() & {"drivers", "runs"}
    ):
        raise UsageError(f"--driver: leave it out; drivers come first, as in: jaxwalk {command} co-trained clearance")
    parts: list[list[str]] = [[]]
    seen: dict[str, list[str]] = {}
    for word in words:
        flag, equals, value = word.partition("=")
        name = flag.removeprefix("--").replace("-", "_")
        if not word.startswith("--") or name not in options.keys() | renamed.keys():
            parts[-1].append(word)
            continue
        if name in renamed:
            raise UsageError(f"{flag}: is written {renamed[name]} now")
        if name in seen and not options[name]:
            raise UsageError(f"{flag}: is given twice; give it once")
        seen.setdefault(name, [flag])
        parts.append(seen[name])
        parts[-1] += [value] if equals else []
    return list(chain.from_iterable({id(part): part for part in parts}.values()))


def _options(kind: type) -> Iterator[tuple[str, bool]]:
    """Yield the name of each option, and whether it takes several values."""
    for name, annotated in get_type_hints(kind, include_extras=True).items():
        plain, *about = get_args(annotated) if hasattr(annotated, "__metadata__") else (annotated,)
        yield _given_name(about) or name, get_origin(plain) is tuple


def _given_name(about: Sequence[Any]) -> str | None:
    """Return the name that a declaration gives to its option, if it does."""
    return next((named for each in about if (named := getattr(each, "name", None))), None)
