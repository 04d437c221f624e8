"""The code blocks of a page: what kind each is, and whether a comment above it says that it isn't run."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass

COMMANDS = ("jaxwalk", "make", "pip", "for", "export", "sed", ".ci/versions", ".venv/bin/python", "python")
"""First words of blocks without a language that are command lines; all others are text."""
REASONS = ("GPU", "cluster", "account", "study", "tool", "data", "torch", "package", "fragment", "installed")
"""Why a block isn't run: what it needs, or that it takes hours, is a tool of this repository, part of a larger program,
or what was done before the tests."""
OPENING = re.compile(r'^```(?P<language>\w*)(?: title="(?P<title>[^"]+)")?$')
MARK = re.compile(r"^<!-- (?P<what>not run|exit): (?P<reason>[^:>]+): .+ -->$")


@dataclass(frozen=True)
class Block:
    """A code block of a page."""

    page: str
    line: int
    language: str
    """Of the fence, else ``sh`` for command lines and ``text`` for the rest."""
    title: str | None
    """The file that it is to be written to."""
    text: str
    left_out: str | None
    """The reason for which it isn't run."""
    code: int
    """The exit code of its last command."""


def blocks(page: str, text: str) -> Iterator[Block]:
    """Yield the blocks of a page."""
    lines = text.split("\n")
    inside = None
    for number, line in enumerate(lines, 1):
        if inside is not None and line == "```":
            yield _block(page, inside, lines, number)
            inside = None
        elif inside is None and OPENING.match(line):
            inside = number
        elif inside is None and line.startswith("```"):
            raise ValueError(f"{page}:{number}: {line}: write a language, and perhaps a title")
    assert inside is None, f"{page}:{inside}: a block without an end"


def _block(page: str, begin: int, lines: list[str], end: int) -> Block:
    opening = OPENING.match(lines[begin - 1])
    assert opening
    text = "\n".join(lines[begin : end - 1]) + "\n"
    mark = MARK.match(lines[begin - 2]) if begin > 1 else None
    left_out = mark["reason"].strip() if mark and mark["what"] == "not run" else None
    code = int(mark["reason"]) if mark and mark["what"] == "exit" else 0
    language = opening["language"] or ("sh" if text.split()[:1] and text.split()[0] in COMMANDS else "text")
    return Block(page, begin, language, opening["title"], text, left_out, code)


def command_lines(text: str) -> Iterator[list[str]]:
    """Yield the words of each command of a block of command lines; comments are left out."""
    for line in text.replace("\\\n", " ").splitlines():
        words = shlex.split(line, comments=True)
        if words:
            yield words
