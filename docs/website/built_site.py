"""Checks of the built site, without a network: every link and anchor leads somewhere, and no page asks another host."""

from __future__ import annotations

import gzip
import re
from collections.abc import Iterator
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

LOADED = {"script": "src", "img": "src", "iframe": "src", "source": "srcset", "video": "src", "audio": "src"}
"""Elements whose attribute is loaded with a page."""
LOADING_LINKS = {"stylesheet", "icon", "preload", "preconnect", "dns-prefetch", "modulepreload", "manifest"}
"""Relations of a <link> that make a browser ask for it."""
OUTSIDE = re.compile(r"^([a-z][a-z0-9+.-]*:)?//|^[a-z][a-z0-9+.-]*:", re.IGNORECASE)
FOREIGN = re.compile(r"""(?:url\(|@import\s+|\bfetch\(|\bimport\(|\.src\s*=\s*)\s*["'`]?(https?:)?//[^)"'`\s]+""")
"""What makes a style sheet or a script ask another host."""


class Page(HTMLParser):
    """The links, anchors and loaded files of a page."""

    def __init__(self, text: str) -> None:
        """Read the page."""
        super().__init__()
        self.anchors: set[str] = set()
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note what an element refers to."""
        given = {name: value or "" for name, value in attrs}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if LOADED.get(tag) in given:
            self.loaded.append(given[LOADED[tag]])
        if tag == "link" and LOADING_LINKS & set(given.get("rel", "").split()):
            self.loaded.append(given.get("href", ""))


@cache
def page_of(path: Path) -> Page:
    """Return a page of the site."""
    return Page(path.read_text(encoding="utf-8"))


def pages(site: Path) -> list[Path]:
    """Return the pages of the site; the one for addresses that don't exist is for servers only."""
    return [path for path in sorted(site.rglob("*.html")) if path.name != "404.html"]


def faults(site: Path) -> list[str]:
    """Return a line for each fault."""
    page_of.cache_clear()
    found = [f"{path.relative_to(site)}: {fault}" for path in pages(site) for fault in _faults(site, path)]
    for path in (*site.rglob("*.css"), *site.rglob("*.js")):
        text = path.read_text(encoding="utf-8", errors="replace")
        found += [f"{path.relative_to(site)}: asks another host: {each[0][:100]}" for each in FOREIGN.finditer(text)]
    return found


def _faults(site: Path, path: Path) -> Iterator[str]:
    page = page_of(path)
    for target in page.loaded:
        if OUTSIDE.match(target) and not target.startswith("data:"):
            yield f"loads {target}"
        elif not target.startswith("data:") and not _place(path, target).is_file():
            yield f"loads {target}, which isn't there"
    for target in page.links:
        if OUTSIDE.match(target):
            continue
        place, anchor = _place(path, target), unquote(target.partition("#")[2])
        if not place.is_file() or site not in place.parents:
            yield f"links to {target}, which isn't there"
        elif anchor and place.suffix == ".html" and anchor not in page_of(place).anchors:
            yield f"links to {target}, which has no such place"


def _place(path: Path, target: str) -> Path:
    """Return the file that a link of a page leads to."""
    inside = unquote(re.split(r"[?#]", target)[0])
    return (path.parent / inside).resolve() if inside else path


def home_size(site: Path) -> int:
    """Return what the home page and all that it loads but pictures weigh, compressed as servers do [bytes].

    A script loads the search's index and worker.
    """
    page = page_of(site / "index.html")
    files = {_place(site / "index.html", target) for target in page.loaded if not target.startswith("data:")}
    search = {site / "search.json", *site.glob("assets/javascripts/workers/*.js")} & {*site.rglob("*")}
    texts = {site / "index.html", *search, *(file for file in files if file.suffix in (".css", ".js", ".json", ".svg"))}
    return sum(len(gzip.compress(file.read_bytes(), 6)) for file in texts)
