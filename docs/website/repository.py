"""Where a file of the repository is in the site, and the Markdown of its pages: links, headings and code blocks."""

from __future__ import annotations

import os
import posixpath
import re
from collections.abc import Callable, Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
"""The repository."""
DOCS = "docs"
AT_THE_TOP = {"CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md", "README.md": "index.md"}
"""Pages of the repository's top folder, and their names in the site."""
NO_PAGES = ("website", "screenshots.py")
"""What lies in docs/ and isn't copied into the site."""
FENCE = re.compile(r"^(```+|~~~+)")
LINK = re.compile(r"(?P<before>\]\()(?P<target>[^)\s]+)(?P<after>\))")
"""A Markdown link or picture, from the end of its text on."""
OUTSIDE = re.compile(r"^([a-z][a-z0-9+.-]*:|//)", re.IGNORECASE)
"""The begin of an address that isn't a path."""


def site_path(file: str) -> str:
    """Return the page, or the file, of the site that shows a file of the repository.

    A file that is no page of its own is shown by one: ``examples/shield.py`` by ``source/examples/shield.py.md``.
    """
    if file in AT_THE_TOP:
        return AT_THE_TOP[file]
    inside = file.removeprefix(f"{DOCS}/")
    return inside if inside != file else f"source/{file}" + ("" if file.endswith(".md") else ".md")


def sources(root: Path = ROOT) -> list[str]:
    """Return the Markdown files that are pages of the site, as paths in the repository."""
    found = [path.relative_to(root).as_posix() for path in sorted((root / DOCS).rglob("*.md"))]
    return [*found, *(name for name in AT_THE_TOP if name != "README.md")]


def prose(text: str) -> Iterator[tuple[int, str]]:
    """Yield the lines of a page that aren't in code blocks, with their numbers from 1."""
    fence = ""
    for number, line in enumerate(text.split("\n"), 1):
        found = FENCE.match(line.lstrip())
        if found and not fence:
            fence = found[1]
        elif found and line.strip() == fence:
            fence = ""
        elif not fence:
            yield number, line


def with_links(text: str, change: Callable[[str], str]) -> str:
    """Return a page with other targets of its links; code blocks stay as they are."""
    prosaic = {number for number, _ in prose(text)}

    def changed(line: str) -> str:
        return LINK.sub(lambda found: found["before"] + change(found["target"]) + found["after"], line)

    lines = enumerate(text.split("\n"), 1)
    return "\n".join(changed(line) if number in prosaic else line for number, line in lines)


def links(text: str) -> Iterator[tuple[int, str]]:
    """Yield the number of the line and the target of each link and picture of a page."""
    for number, line in prose(text):
        yield from ((number, found["target"]) for found in LINK.finditer(line))
        yield from ((number, target) for target in re.findall(r'(?:src|srcset|href)="([^"]+)"', line))


def anchors(text: str) -> set[str]:
    """Return the anchors of a page's headings, as forges and the site make them, and those that it sets itself."""
    found: dict[str, int] = {}
    names = set()
    for _, line in prose(text):
        names |= set(re.findall(r'id="([^"]+)"', line))
        if heading := re.match(r"#{1,6} +(.*?)\s*#*$", line):
            slug = slug_of(heading[1])
            count = found[slug] = found.get(slug, -1) + 1
            names.add(f"{slug}-{count}" if count else slug)
    return names


def slug_of(heading: str) -> str:
    """Return the anchor of a heading."""
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading)
    plain = re.sub(r"[`*]", "", plain)
    return re.sub(r"[^\w\- ]", "", plain.strip().lower()).replace(" ", "-")


def target_file(page: str, target: str) -> str:
    """Return the file of the repository that a link of a page leads to, as a path from its top."""
    path = target.partition("#")[0]
    return posixpath.normpath(posixpath.join(posixpath.dirname(page), path)) if path else page


def in_site(page: str, target: str) -> str:
    """Return how a link of a page of the repository is written in the site."""
    if OUTSIDE.match(target) or target.startswith("#"):
        return target
    here, there = site_path(page), site_path(target_file(page, target))
    anchor = target.partition("#")[1] + target.partition("#")[2]
    return os.path.relpath(there, os.path.dirname(here) or ".").replace(os.sep, "/") + anchor
