"""Assembles the pages of the site: those of docs/, those made from the code, and the files that they link to."""

from __future__ import annotations

import shutil
from pathlib import Path

from website.command_pages import commands_page
from website.reference_pages import FOLDER, reference_pages
from website.repository import DOCS, NO_PAGES, ROOT, in_site, links, site_path, sources, target_file, with_links

LANGUAGES = {".py": "python", ".toml": "toml", ".json": "json", ".cff": "yaml", ".yml": "yaml"}
"""How files are highlighted, by their ending."""
BESIDE = {"site.css": "stylesheets", "worker-from-disk.js": "javascripts", "access.js": "javascripts"}
"""Files of this folder that the site has too, and in which of its folders."""


def assemble(out: Path) -> None:
    """Write all pages into a folder, which is made anew."""
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(ROOT / DOCS, out, ignore=shutil.ignore_patterns(*NO_PAGES, "__pycache__"))
    for name, folder in BESIDE.items():
        _write(out / folder / name, (Path(__file__).parent / name).read_text(encoding="utf-8"))
    pages = dict(reference_pages()) | {f"{FOLDER}/commands.md": commands_page()}
    for page in sources():
        text = (ROOT / page).read_text(encoding="utf-8")
        pages[site_path(page)] = with_links(text, lambda target, page=page: in_site(page, target))
    for page, text in pages.items():
        _write(out / page, text)
    for file in linked_files():
        _write(out / site_path(file), shown(file))


def linked_files() -> list[str]:
    """Return the files and folders of the repository that pages link to, and that are no pages of their own."""
    found = set()
    for page in sources():
        for _, target in links((ROOT / page).read_text(encoding="utf-8")):
            file = target_file(page, target)
            if (ROOT / file).exists() and site_path(file).startswith("source/"):
                found.add(file)
    return sorted(found)


def shown(file: str) -> str:
    """Return the page that shows a file, or all files of a folder."""
    path = ROOT / file
    if path.suffix == ".md":
        text = path.read_text(encoding="utf-8")
        return with_links(text, lambda target: _flat(file, target))
    files = sorted(path.glob("*.*")) if path.is_dir() else [path]
    parts = [f"# {file}\n"]
    for each in files:
        parts += [f"## {each.name}\n"] if path.is_dir() else []
        parts.append(f"````{LANGUAGES.get(each.suffix, 'text')}\n{each.read_text(encoding='utf-8')}````\n")
    return "\n".join(parts)


def _flat(file: str, target: str) -> str:
    """Return a link of a shown page: it works if it leads to a page of the site."""
    there = target_file(file, target)
    return in_site(file, target) if there in sources() or there in linked_files() else target


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
