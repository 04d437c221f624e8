"""How numbers and lists are written in sentences."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from html import escape

LONGEST = 200
"""Longest text of a stranger that is shown [characters]."""
MOST_NAMED = 4
"""Longer lists are cut off."""


def counted(number: int, what: str) -> str:
    """Return a number of things in words, as in ``1 scenario`` or ``2,000 scenarios``; ``what`` is the singular."""
    return f"{number:,} {what}" + ("" if number == 1 else "s")


def first_of(names: Sequence[str], what: str) -> str:
    """Return names in words, as in ``a, b, c, d and 16 more maps``; ``what`` is the singular of what they name."""
    more = len(names) - MOST_NAMED
    return ", ".join(names[:MOST_NAMED]) + (f" and {counted(more, f'more {what}')}" if more > 0 else "")


def plain(text: str, longest: int = LONGEST) -> str:
    """Return a stranger's text for a terminal, with at most ``longest`` characters.

    A space stands for each character that controls a terminal, ends a line, can't be seen or changes the direction.
    """
    seen = "".join(" " if _controls(sign) else sign for sign in text[: longest + 1])
    return seen if len(seen) <= longest else seen[: longest - 3] + "..."


def _controls(sign: str) -> bool:
    category = unicodedata.category(sign)
    return category[0] == "C" or category in ("Zl", "Zp")


def plain_markdown(text: str, longest: int = LONGEST) -> str:
    """Return a stranger's text for a page in Markdown: as `plain`, and neither HTML, a link, nor the end of a cell.

    Nor do bare addresses of pages and mail become links, as forges make them (GitHub Flavored Markdown, section 6.9).
    """
    marked = re.sub(r"([\\`*_\[\]{}|!])", r"\\\1", escape(plain(text, longest), quote=False))
    without_pages = re.sub(r":(?=//)|(?<=www)\.", lambda found: f"&#{ord(found[0])};", marked, flags=re.IGNORECASE)
    return without_pages.replace("@", "<!-- -->@")  # of mail, forges read the sign as any other, however it is written
