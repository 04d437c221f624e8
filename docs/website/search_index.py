"""The index of the search, made small: every page loads it."""

from __future__ import annotations

import json
import re
from pathlib import Path

LEFT_OUT = (
    "source/", "changelog.html", "evidence.html", "bench/", "testing.html", "architecture.html", "extending.html",
    "results-paper.html", "frontier-results.html", "benchmark.html",
)  # fmt: skip
"""Beginnings of the addresses of pages that users don't search: files, tables of numbers, and what developers read."""
NOT_SEARCHED = re.compile(
    r"<pre.*?</pre>|</?[a-z]+[^>]*>|\[-?[\d.]+, -?[\d.]+\]|-?\b\d+\.\d+\b|\b\d{1,3}(,\d{3})+\b|\b\d+ %", re.DOTALL
)
"""Code blocks, tags, intervals, decimal numbers, thousands and percentages."""
LONE_MARKS = re.compile(r"(?<!\S)[^\w\s]+(?!\S)")
"""Brackets, commas and signs that stand alone, mostly where something else was taken out."""
LABELS = re.compile(r"\s*<small>.*?</small>")
"""What the reference writes after a name, such as `instance-attribute`."""
TABLES = re.compile(r"\b(Parameters|Returns|Yields): (Name )?Type .*?(?=\bRaises: Type |$)")
"""A docstring's tables of parameters and results. Names of errors stay: they are what somebody looks for."""


def shrink(site: Path) -> None:
    """Write the index anew without what nobody searches, and once more as a script: a page from disk reads no JSON."""
    index = json.loads((site / "search.json").read_text(encoding="utf-8"))
    items = [item for item in index["items"] if not item["location"].startswith(LEFT_OUT)]
    index["items"] = [
        {**item, "title": LABELS.sub("", item["title"]), "text": TABLES.sub("", _words(item["text"]))} for item in items
    ]
    text = json.dumps(index, ensure_ascii=False, separators=(",", ":"))
    (site / "search.json").write_text(text, encoding="utf-8")
    (site / "search.js").write_text(f"var __index = {text}", encoding="utf-8")


def _words(text: str) -> str:
    return " ".join(LONE_MARKS.sub(" ", NOT_SEARCHED.sub(" ", text)).split())
