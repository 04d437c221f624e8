from __future__ import annotations

import re
from pathlib import Path

import pytest

from jaxwalk.evaluation import ScenarioSet
from jaxwalk.wording import counted, first_of, plain, plain_markdown

ROOT = Path(__file__).parents[1]


def test_one_is_singular_and_thousands_have_commas():
    assert [counted(n, "scenario") for n in (0, 1, 2, 2000)] == [
        "0 scenarios", "1 scenario", "2 scenarios", "2,000 scenarios",
    ]  # fmt: skip
    assert ScenarioSet(1, "", 3).name == "1 scenario of seed 3"


def test_long_lists_are_cut_off():
    assert [first_of(list("abcdefg")[:n], "map") for n in (1, 4, 5, 7)] == [
        "a", "a, b, c, d", "a, b, c, d and 1 more map", "a, b, c, d and 3 more maps",
    ]  # fmt: skip


def test_a_strangers_text_controls_no_terminal():
    assert plain("a\x1b[31mb\nc\u202ed\u2028e\x7f") == "a [31mb c d e "
    assert plain("Zoë's 車") == "Zoë's 車"
    assert plain("x" * 300, 20) == "x" * 17 + "..." and plain("x" * 20, 20) == "x" * 20


def test_a_strangers_text_is_no_markup_of_a_page():
    assert plain_markdown("<script>a|b</script>") == "&lt;script&gt;a\\|b&lt;/script&gt;"
    assert plain_markdown("![x](javascript:y) {: onclick=z}") == r"\!\[x\](javascript:y) \{: onclick=z\}"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("http://x.org/a_b", r"http&#58;//x.org/a\_b"),
        ("see HTTPS://x.org, ftp://y", "see HTTPS&#58;//x.org, ftp&#58;//y"),
        ("www.x.org and WWW.y", "www&#46;x.org and WWW&#46;y"),
        ("me@x.org", "me<!-- -->@x.org"),
        ("file.py:Class", "file.py:Class"),
    ],
)
def test_a_strangers_address_is_no_link(text, shown):
    """On a forge the first four would become links; none of what is shown does (tried with cmarkgfm 2025.10.22)."""
    assert plain_markdown(text) == shown


def test_messages_and_help_name_pages_in_one_form():
    """(docs: NAME), in parentheses of its own, of a page that is there; `jaxwalk --help` explains NAME itself."""
    texts = {path: " ".join(path.read_text("utf-8").split()) for path in (ROOT / "src").rglob("*.py")}
    named = [(path, name) for path, text in texts.items() for name in re.findall(r"\(docs: ([^()]*)\)", text)]
    assert len(named) > 40
    lost = [
        (path.name, name) for path, name in named if name != "NAME" and not (ROOT / "docs" / f"{name}.md").is_file()
    ]
    assert not lost, "no such page"
    otherwise = [path.name for path, text in texts.items() if re.search(r"(?<!\()docs: ", text)]
    assert not otherwise, "write (docs: NAME)"
