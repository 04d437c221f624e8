"""Files are there whole or not at all, whoever writes them, and an error names the file."""

import errno
import os

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from jaxwalk import writing
from jaxwalk.report.style import save
from jaxwalk.writing import current, is_unfinished, remove_unfinished, together, whole, write_whole
from limits import files_at_most


def _parquet(path):
    pyarrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    table = pyarrow.table({"x": np.random.default_rng(0).normal(size=10_000)})
    with whole(path) as unfinished, parquet.ParquetWriter(unfinished, table.schema) as writer:
        writer.write_table(table)


def _gif(path):
    noise = np.random.default_rng(0).integers(0, 255, (100, 100, 3), np.uint8)
    with whole(path) as unfinished:
        Image.fromarray(noise).save(unfinished)


WRITERS = {
    "text.txt": lambda path: write_whole(path, "much " * 1000),
    "bytes.bin": lambda path: write_whole(path, b"much " * 1000),
    "table.parquet": _parquet,
    "film.gif": _gif,
    "figure.svg": lambda path: save(Figure(), path.parent, "figure"),
}


@pytest.mark.parametrize("name", WRITERS)
def test_a_full_disk_leaves_what_was_there(name, tmp_path):
    path = tmp_path / name
    path.write_bytes(b"before")
    with files_at_most(500), pytest.raises(OSError, match="too large") as caught:
        WRITERS[name](path)
    assert caught.value.filename == str(path)
    assert [file.name for file in tmp_path.iterdir()] == [name]
    assert path.read_bytes() == b"before"
    WRITERS[name](path)
    assert path.stat().st_size > 500


def test_it_is_there_only_at_the_end(tmp_path):
    with whole(tmp_path / "a.svg") as unfinished:
        unfinished.write_text("<svg/>")
        assert not (tmp_path / "a.svg").exists()
        assert unfinished.suffix == ".svg"
    assert [file.read_text() for file in tmp_path.iterdir()] == ["<svg/>"]


def test_a_disk_that_fails_at_the_end_counts(tmp_path, monkeypatch):
    def fail(_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(OSError, match="No space left") as caught:
        write_whole(tmp_path / "a.txt", "text")
    assert caught.value.filename == str(tmp_path / "a.txt")
    assert not list(tmp_path.iterdir())


def test_a_librarys_own_words_are_kept(tmp_path):
    with pytest.raises(OSError, match="the encoder has gone") as caught, whole(tmp_path / "a.mp4"):
        raise OSError("the encoder has gone")
    assert caught.value.filename == str(tmp_path / "a.mp4")


def test_what_a_killed_process_left_is_known_by_its_name(tmp_path):
    mine = (tmp_path / ".hidden", tmp_path / "a.part", tmp_path / "b.part.json", tmp_path / "c.json")
    for path in mine:
        path.write_text("mine")
    with whole(tmp_path / "config.json") as unfinished:
        (tmp_path / unfinished.name.replace(str(os.getpid()), "1")).write_text("left")
        unfinished.write_text("{}")
        assert is_unfinished(unfinished)
    with whole(tmp_path / "LICENSE") as unfinished:
        (tmp_path / unfinished.name.replace(str(os.getpid()), "1")).write_text("left")
        unfinished.write_text("free")
    remove_unfinished(tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {path.name for path in mine} | {"config.json", "LICENSE"}


def test_files_written_together_appear_together(tmp_path):
    with together():
        write_whole(tmp_path / "a", "new")
        with whole(tmp_path / "b") as unfinished:
            unfinished.write_text("newer")
        assert not (tmp_path / "a").exists()
        assert current(tmp_path / "a").read_text() == "new"
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "new", "b": "newer"}
    assert current(tmp_path / "a") == tmp_path / "a"


@pytest.mark.parametrize("fault", ["the second", "a folder in the way", "Ctrl-C"])
def test_of_files_written_together_one_that_fails_leaves_the_older_ones(fault, tmp_path, monkeypatch):
    (tmp_path / "a").write_text("old")
    (tmp_path / "b").mkdir() if fault == "a folder in the way" else (tmp_path / "b").write_text("old")
    before = _contents(tmp_path)
    expected = KeyboardInterrupt if fault == "Ctrl-C" else OSError
    with pytest.raises(expected) as raised, together():
        write_whole(tmp_path / "a", "new")
        if fault == "the second":
            monkeypatch.setattr(writing, "_to_disk", lambda _: (_ for _ in ()).throw(OSError(errno.ENOSPC, "No space")))
        if fault == "Ctrl-C":
            raise KeyboardInterrupt
        write_whole(tmp_path / "b", "new")
    assert _contents(tmp_path) == before
    assert fault == "Ctrl-C" or raised.value.filename == str(tmp_path / "b")


def test_a_process_that_must_end_at_once_leaves_nothing_half_written(tmp_path):
    with whole(tmp_path / "a") as unfinished:
        unfinished.write_text("half")
        writing.remove_own_unfinished()
        assert not any(tmp_path.iterdir())
        unfinished.write_text("whole")


def _contents(folder):
    return {path.name: path.read_text() if path.is_file() else None for path in folder.iterdir()}
