"""The pages as they are in the repository: links, the site's navigation, and what is made from the code."""

from __future__ import annotations

import re
from importlib import import_module

import pytest

from jaxwalk.cli.commands import COMMANDS
from website.assemble import linked_files
from website.command_pages import commands_page, field_texts
from website.reference_pages import MODULES, file_name, packages_with_names, public_names, reference_pages
from website.repository import OUTSIDE, ROOT, anchors, in_site, links, prose, site_path, slug_of, sources, target_file

PAGES = [*sources(), "README.md"]
REFERENCE = dict(reference_pages())
NEEDS = {"jaxwalk.adapters.stable_baselines3": "stable_baselines3"}
"""Packages without which a module can't be imported, and which aren't among the tools of development."""


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    wrong = []
    for line, target in links(text):
        if OUTSIDE.match(target):
            continue
        file, anchor = target_file(page, target), target.partition("#")[2]
        if not (ROOT / file).exists():
            wrong.append(f"{page}:{line}: {target}: there is no such file")
        elif anchor and file.endswith(".md") and anchor not in anchors((ROOT / file).read_text(encoding="utf-8")):
            wrong.append(f"{page}:{line}: {target}: there is no such heading")
    assert not wrong, "\n".join(wrong)


def test_every_page_has_one_place_in_the_navigation():
    named = re.findall(r"(?:- |: )(\S+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(named) == sorted(set(named)), "a page is named twice"
    data = {site_path(page) for page in sources() if page.startswith("docs/bench/")}
    made = {*REFERENCE, "reference/commands.md"}
    assert set(named) == {site_path(page) for page in sources()} - data | made


def test_every_package_with_public_names_has_a_page():
    assert set(packages_with_names()) - set(MODULES) == set()


@pytest.mark.parametrize("module", MODULES)
def test_every_public_name_is_described(module):
    """By the running code, too: nothing that a module offers is forgotten."""
    if module in NEEDS:
        pytest.importorskip(NEEDS[module])
    names = public_names(module)
    offered = getattr(import_module(module), "__all__", None)
    if offered is not None:
        assert {each.name for each in names} == {name for name in offered if name != "__version__"}
    page = REFERENCE[f"reference/{file_name(module)}"]
    for each in names:
        assert f"::: {each.path}\n" in page or f"{{ #{each.path} }}" in page or f"#{each.path})" in page, each.path
        assert hasattr(import_module(each.home), each.name), each.path


def test_every_command_and_option_is_listed():
    page = commands_page()
    for command in COMMANDS:
        section = page.partition(f"## jaxwalk {command.name}\n")[2].partition("\n## ")[0]
        for name, text in field_texts(command.options).items():
            assert text[:20].replace("|", r"\|") in section, (command.name, name)
        rows = [line for line in section.splitlines() if line.startswith("| ")]
        assert len(rows) == 2 + len(command.options.__dataclass_fields__), command.name
    assert "| `--driver` | `D [D ...]` |" in page and "One of `fast`, `paper`" in page


def test_pages_that_the_command_line_names_are_there():
    named = set(re.findall(r"docs: \[[a-z-]+\]\(\.\./([a-z-]+\.md)\)", commands_page()))
    assert "shields.md" in named and all((ROOT / "docs" / page).is_file() for page in named)
    assert not re.search(r"docs/[a-z-]+\.md", commands_page())


def test_files_that_pages_link_to_have_pages():
    assert "examples/shield.py" in linked_files() and "examples/extending" in linked_files()
    assert in_site("docs/shields.md", "../examples/shield.py") == "source/examples/shield.py.md"
    assert in_site("docs/tutorials/my-driver.md", "../drivers.md#in-python") == "../drivers.md#in-python"
    assert in_site("CONTRIBUTING.md", "docs/extending.md") == "extending.md"
    assert in_site("docs/extending.md", "../CONTRIBUTING.md") == "contributing.md"
    assert in_site("docs/index.md", "https://example.org") == "https://example.org"


@pytest.mark.parametrize(
    ("heading", "slug"),
    [
        ("What is where", "what-is-where"),
        ("Shields (`summary[SHIELD_INTERVENTIONS]`)", "shields-summaryshield_interventions"),
        ("[Maps](maps.md) & *more*", "maps--more"),
    ],
)
def test_headings_have_the_anchors_of_forges(heading, slug):
    assert slug_of(heading) == slug


def test_code_is_no_prose():
    text = "a [b](c.md)\n```text\n[d](e.md)\n```\n## f\n## f\n"
    assert list(links(text)) == [(1, "c.md")] and anchors(text) == {"f", "f-1"}
    assert [line for line, _ in prose(text)] == [1, 5, 6, 7]
