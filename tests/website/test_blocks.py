"""The code blocks of all pages: tutorials run as they are written, command lines elsewhere with small numbers."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from dataclasses import replace
from itertools import groupby
from pathlib import Path

import jax
import pytest

from hostile.command_lines import nothing_is_done
from jaxwalk.cli import main
from jaxwalk.sim.suites import SUITES
from website.blocks import REASONS, Block, blocks, command_lines
from website.brief import CHECKED, ELSEWHERE, as_a_shell_does, briefly, clear, fewer_streets, provide, written
from website.repository import ROOT, sources

PAGES = [page for page in ("README.md", *sources()) if page != "CHANGELOG.md"]
TUTORIALS = [page for page in PAGES if page.startswith("docs/tutorials/")]
BLOCKS = {page: list(blocks(page, (ROOT / page).read_text(encoding="utf-8"))) for page in PAGES}
DRIVER = ROOT / "examples" / "my_driver.py"
EXAMPLES = {path.read_text().split('"""\n\n', 1)[-1] for path in (ROOT / "examples").rglob("*.py")}
"""Programs that .ci/run runs, and that pages show word for word."""
LONGEST = 900
"""Seconds that one block may take."""


def test_a_block_that_is_not_run_has_a_reason_and_no_tutorial_has_one():
    out = [block for page in BLOCKS.values() for block in page if block.left_out is not None]
    assert {block.left_out for block in out} <= set(REASONS)
    assert {block.left_out for block in out if block.page in TUTORIALS} <= {"installed"}


def test_languages_are_known():
    known = {"sh", "text", "python", "toml", "json", "xml"}
    assert {block.language for page in BLOCKS.values() for block in page} <= known


def test_the_tutorial_shows_the_driver_of_the_examples():
    shown = next(block.text for block in BLOCKS["docs/tutorials/my-driver.md"] if block.title == "my_driver.py")
    assert shown.strip() == DRIVER.read_text().partition('"""\n\n')[2].strip()


@pytest.mark.parametrize("page", PAGES)
def test_data_can_be_read(page):
    for block in BLOCKS[page]:
        if block.left_out is None and block.language in ("toml", "json"):
            read = {"toml": tomllib.loads, "json": json.loads}[block.language]
            assert read(block.text), f"{page}:{block.line}: nothing in it"


def _kind(block: Block) -> str:
    return "file" if block.title else block.language


def check_run(words: list[str], place: Path, expected: int = 0) -> None:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    plain = {name: value for name, value in os.environ.items() if name not in ("PYTHONWARNINGS",)}
    kept = jax.config.jax_compilation_cache_dir or place / ".cache"  # pages repeat each other's commands
    cache = {"JAX_COMPILATION_CACHE_DIR": str(kept), "PATH": path}
    done = subprocess.run(
        words, cwd=place, env=plain | cache, capture_output=True, text=True, timeout=LONGEST, check=False
    )
    assert done.returncode == expected, f"{words[-1]}\n{done.stdout}\n{done.stderr}"


@pytest.mark.long
@pytest.mark.parametrize("page", TUTORIALS)
def test_a_tutorial_runs_as_it_is_written(page, tmp_path):
    shutil.copy(DRIVER, tmp_path)
    check_blocks([block for block in BLOCKS[page] if block.left_out is None], tmp_path)


def check_blocks(found: list[Block], place: Path) -> None:
    """Run blocks in their order, and check how each ends. Python that isn't interrupted by others is one program."""
    for kind, several in groupby(found, _kind):
        group = list(several)
        if kind == "python":
            check_run([sys.executable, "-c", "\n".join(block.text for block in group)], place)
        for block in group:
            if kind == "file":
                (place / str(block.title)).write_text(block.text)
            elif kind == "sh":
                check_run(["bash", "-e", "-c", block.text], place, block.code)


OTHERS = [page for page in PAGES if page not in TUTORIALS]
PYTHON = {
    page: [b for b in BLOCKS[page] if b.language == "python" and b.left_out is None and b.text not in EXAMPLES]
    for page in OTHERS
}
"""The Python blocks of a page, but for programs that .ci/run runs as examples."""


@pytest.mark.long
@pytest.mark.parametrize("page", [page for page, found in PYTHON.items() if found])
def test_python_runs(page, tmp_path):
    check_blocks(PYTHON[page], tmp_path)


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """The run folder of a tiny training."""
    path = tmp_path_factory.mktemp("trained") / "run"
    assert main(f"train --run {path} --updates 2 --environments 8 --steps 8 --minibatches 2".split()) == 0
    return path


@pytest.fixture
def small_suites(monkeypatch):
    """Suites of one street each."""
    for name, where in SUITES.items():
        maps = tuple(re.sub(r":\d+$", ":1", each) for each in where.maps)
        monkeypatch.setitem(SUITES, name, replace(where, maps=maps, people=min(where.people or 6, 6)))


@pytest.mark.long
@pytest.mark.parametrize("page", [page for page in OTHERS if any(b.language == "sh" for b in BLOCKS[page])])
def test_command_lines_run_briefly(page, tmp_path, monkeypatch, trained, small_suites):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "examples", "examples")
    for block in BLOCKS[page]:
        if block.title:
            Path(block.title).write_text(block.text)
        elif block.language == "toml" and block.text.startswith('name = "mine"'):
            Path("mine.toml").write_text(fewer_streets(block.text))
    for block in BLOCKS[page]:
        for words in command_lines(block.text) if block.language == "sh" and block.left_out is None else ():
            check_line([word.replace("$name", "co-trained").rstrip(";") for word in words], trained)


def check_line(words: list[str], trained: Path) -> None:
    """Run one command, or check that what it names is there."""
    if words[0] == "jaxwalk" and not set(words) & set(ELSEWHERE):
        _jaxwalk(briefly(words), trained)
    elif words[0] == "make":
        targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
        assert {word for word in words[1:] if "=" not in word} <= targets, words
    elif words[0].endswith("python") and words[1].endswith(".py"):
        assert (ROOT / words[1]).is_file(), words
    elif words[0] == "pip":
        extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
        assert set(re.findall(r"\[(\w+)\]", " ".join(words))) <= set(extras), words


def _jaxwalk(words: list[str], trained: Path) -> None:
    if words[1:3] == ["train", "--config"]:
        page = (ROOT / "docs" / "recipes.md").read_text(encoding="utf-8")
        Path(words[3]).write_text(fewer_streets(page.partition('title="mine.toml"\n')[2].partition("```")[0]))
    provide(words, trained)
    if words[1] in CHECKED:
        with nothing_is_done():
            assert main(words[1:]) == 0, words
        clear(written(words))
    else:
        assert main(as_a_shell_does(words)[1:]) == 0, words
