"""Our own trajectories as a table: what stands in it, and that reading it back measures the same."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pyarrow
import pyarrow.parquet
import pytest

from jaxwalk.formats import track_file
from jaxwalk.formats.areas import areas_of
from jaxwalk.formats.measured import measure_all
from jaxwalk.formats.track_file import TrackFile, write_tracks
from jaxwalk.formats.tracks import OF_CARS, OF_PEOPLE, REQUIRED, TracksError, tracks_of
from jaxwalk.metrics import CROSSINGS, SURROGATES, measure, summarise
from metrics.scenes import JAYWALK, Scene, Walk, trajectory


@pytest.fixture(scope="module")
def file(episodes, recorded, network, tmp_path_factory):
    path = tmp_path_factory.mktemp("tracks") / "tracks.parquet"
    write_tracks(path, iter(episodes), about={"dt": recorded.dt, "map": "paper"}, areas=areas_of(network))
    return path


def _rewritten(file, path, change):
    """The file with its table changed."""
    pyarrow.parquet.write_table(change(pyarrow.parquet.read_table(file)), path)
    return TrackFile(path)


def test_a_row_for_everybody_and_every_frame():
    walk = Walk(x=8.0, y=-3.0, vy=1.0, crossings=[(2, 3, JAYWALK)], tau=0.25)
    stands = Walk(x=5.0, y=9.0)
    recorded = trajectory(
        Scene(length=3, people=[walk, stands], speed=5.0, touched=[0]), Scene(length=5, people=[stands, stands])
    )
    first, second = tracks_of(recorded)
    assert (len(first.t), len(second.t)) == (3 * 4, 3 * 6)
    assert first.id.tolist() == [0] * 4 + [1] * 4 + [2] * 4
    assert first.t[:4] == pytest.approx([0, 0.1, 0.2, 0.3])
    assert first.x[:4] == pytest.approx([0, 0.5, 1.0, 1.5])
    assert first.y[4:8] == pytest.approx([-3.0, -2.9, -2.8, -2.7])
    assert first.heading[4:8] == pytest.approx([np.pi / 2] * 4), "who stands at first already faces the way it will go"
    assert first.heading[8:].tolist() == [0.0] * 4
    assert set(first.type.tolist()) == {"car", "pedestrian"}
    assert first.known["ending"][0] == "collision"
    assert second.known["ending"][0] == "timeout"
    assert first.known["touched"].nonzero()[0].tolist() == [7], "whom the car touched, in the last frame"
    assert first.known["crossing"][4:8].tolist() == ["none", "jaywalk", "jaywalk", "jaywalk"]
    assert first.known["jaywalking_tendency"][4] == 0.25


def test_the_file_says_units_step_and_ground(file):
    schema = pyarrow.parquet.read_schema(file)
    assert set(schema.names) == {*REQUIRED, *OF_CARS, *OF_PEOPLE}
    assert schema.field("heading").metadata == {b"unit": b"rad"}
    opened = TrackFile(file)
    assert opened.about == {"schema": 1, "dt": 0.1, "map": "paper"}
    kinds = [one["properties"]["kind"] for one in json.loads(schema.metadata[b"jaxwalk_areas"])["features"]]
    assert (kinds.count("roadway"), kinds.count("crosswalk")) == (3, 6)
    table = pyarrow.parquet.read_table(file, columns=["type", "on_roadway", "speed"]).to_pydict()
    assert {on is None for on, kind in zip(table["on_roadway"], table["type"], strict=True) if kind == "car"} == {True}
    assert {v is None for v, kind in zip(table["speed"], table["type"], strict=True) if kind == "pedestrian"} == {True}


def test_what_is_read_is_what_was_written(file, episodes):
    assert pyarrow.parquet.ParquetFile(file).num_row_groups == 2, "two groups of rows: read one after the other"
    back = list(TrackFile(file).recordings())
    assert [one.episode for one in back] == [one.episode for one in episodes]
    for one, other in zip(back, episodes, strict=True):
        for name in REQUIRED[1:]:
            assert np.array_equal(getattr(one, name), getattr(other, name)), name
        for name, values in one.known.items():
            assert np.array_equal(values, other.known[name], equal_nan=values.dtype.kind == "f"), name


def test_measuring_the_file_is_measuring_the_episodes(file, recorded, street):
    opened = TrackFile(file)
    found = measure_all(((one, opened.areas) for one in opened.recordings()), config=street.config)
    native = measure(recorded, config=street.config)
    assert found.rows.tables.keys() == native.tables.keys() > {"outcomes", "crossings", "encounters"}
    for table, columns in native.tables.items():
        for name, expected in vars(columns).items():
            values = getattr(found.rows.tables[table], name)
            assert values.dtype == expected.dtype, (table, name)
            # (the car's direction is turned into an angle and back: the last bit of a float32)
            assert np.allclose(values, expected, rtol=2e-6, atol=2e-6, equal_nan=True), (table, name)
            if expected.dtype.kind != "f":
                assert np.array_equal(values, expected), (table, name)
    document, expected = found.as_dict(), summarise(native).as_dict()
    assert document["left_out"] == {}
    for name in ("outcomes", "attribution", "jaywalk_rate", "waiting", "speed_differential"):
        assert document[name] == expected[name], name
    share = document["surrogates"]["crosswalk"]["ttc_critical"]
    assert share == expected["surrogates"]["crosswalk"]["ttc_critical"]
    assert share["count"] > 30


def test_places_tell_who_crosses_how(episodes, recorded, areas, street):
    bare = [(dataclasses.replace(one, known={}), areas) for one in episodes]
    found = measure_all(bare, config=street.config)
    native = measure(recorded, config=street.config)
    for name in ("episode", "ped", "type", "enter", "last"):
        assert np.array_equal(getattr(found.rows[CROSSINGS], name), getattr(native[CROSSINGS], name)), name
    assert np.allclose(found.rows[SURROGATES].pet, native[SURROGATES].pet, equal_nan=True)
    assert set(found.rows[CROSSINGS].type.tolist()) == {1, 2}
    document = found.as_dict()
    assert document.keys() == {
        "episodes", "kilometres", "hours", "speed_differential", "encounters", "surrogates", "surrogate_distributions",
        "contacts", "comfort", "near_misses", "left_out",
    }  # fmt: skip
    assert "ending" in document["left_out"]["outcomes, attribution, passing, impact_tail, yielded, those who were hit"]
    assert "fatal" not in document["surrogates"]["jaywalk"]


def test_text_may_be_stored_as_categories(file, tmp_path, episodes):
    def categories(table):
        at = table.schema.get_field_index("type")
        return table.set_column(at, "type", table["type"].dictionary_encode())

    back = next(_rewritten(file, tmp_path / "categories.parquet", categories).recordings())
    assert back.type.tolist() == episodes[0].type.tolist()


WRONG = {
    "no column": (lambda table: table.drop_columns(["heading", "vx"]), "has no column vx, heading"),
    "a column twice": (lambda table: table.append_column("x", table["x"]), "has several columns x; keep one of each"),
    "empty values": (
        lambda table: table.set_column(4, "x", pyarrow.nulls(len(table), pyarrow.float32())),
        "column x has empty values",
    ),
    "not finite": (
        lambda table: table.set_column(4, "x", pyarrow.array(np.full(len(table), np.inf))),
        "column x of episode 0 is not finite",
    ),
    "words": (
        lambda table: table.set_column(1, "t", pyarrow.array(["soon"] * len(table))),
        "column t holds string; make it double",
    ),
    "disorder": (
        lambda table: table.take(np.argsort(np.arange(len(table)) % 2, kind="stable")),
        "the rows of episode 0 are not together",
    ),
    "another version": (
        lambda table: table.replace_schema_metadata({b"jaxwalk": b'{"schema": 99}'}),
        "is of schema 99",
    ),
}


@pytest.mark.parametrize("change, message", WRONG.values(), ids=WRONG)
def test_tables_that_cannot_be_used(file, tmp_path, change, message):
    with pytest.raises(TracksError, match=message):
        list(_rewritten(file, tmp_path / "wrong.parquet", change).recordings())


def test_words_that_are_no_text_are_refused(file, tmp_path):
    def garbled(table):
        words = pyarrow.array([b"\xe3ar"] * len(table)).view(pyarrow.string())
        return table.set_column(table.schema.get_field_index("type"), "type", words)

    with pytest.raises(TracksError, match="isn't UTF-8"):
        list(_rewritten(file, tmp_path / "garbled.parquet", garbled).recordings())


def test_columns_of_other_programs_are_passed_over(file, tmp_path, episodes):
    """Also one that could fill memory: it isn't read."""
    back = _rewritten(
        file, tmp_path / "more.parquet", lambda table: table.append_column("weather", [[["rain", "fog"]] * len(table)])
    )
    assert "weather" not in back.known
    assert np.array_equal(next(back.recordings()).x, episodes[0].x)


def test_a_column_of_words_may_be_empty(file, tmp_path, episodes):
    """Nobody's ending is known then: the text is empty."""

    def emptied(table):
        return table.set_column(table.schema.get_field_index("ending"), "ending", pyarrow.nulls(len(table)))

    first = next(_rewritten(file, tmp_path / "empty.parquet", emptied).recordings())
    assert set(first.known["ending"].tolist()) == {""} and len(first.t) == len(episodes[0].t)


def test_a_table_without_rows_has_no_recordings(file, tmp_path):
    assert list(_rewritten(file, tmp_path / "none.parquet", lambda table: table.slice(0, 0)).recordings()) == []


def test_no_parquet_file(tmp_path, episodes, monkeypatch):
    (tmp_path / "text.parquet").write_text("t,id\n")
    with pytest.raises(TracksError, match="not a Parquet file"):
        TrackFile(tmp_path / "text.parquet")
    with pytest.raises(TracksError, match="no trajectories to write"):
        write_tracks(tmp_path / "none.parquet", [], about={})
    assert [path.name for path in tmp_path.iterdir()] == ["text.parquet"], "nothing half-written is left"
    monkeypatch.setattr(track_file.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(TracksError, match=r"jaxwalk\[data\]"):
        write_tracks(tmp_path / "tracks.parquet", episodes, about={})


def test_a_small_file_does_not_fill_memory(file, tmp_path, monkeypatch):
    """A word is written once, whatever the number of its rows; and a group of rows is read at once."""
    long = "x" * 1001

    def change(table):
        at = table.schema.get_field_index("type")
        return table.set_column(at, "type", pyarrow.array([long] * len(table)))

    with pytest.raises(TracksError, match=r"column type has words of 1,001 characters; correct it"):
        next(_rewritten(file, tmp_path / "words.parquet", change).recordings())
    table = pyarrow.parquet.read_table(file).slice(0, 150)
    pyarrow.parquet.write_table(table, tmp_path / "groups.parquet", row_group_size=50)
    monkeypatch.setattr(track_file, "MOST_ROWS", 90)
    with pytest.raises(TracksError, match=r"has 100 rows in episode \d+; write it with at most 90"):
        next(TrackFile(tmp_path / "groups.parquet").recordings())
    monkeypatch.setattr(track_file, "MOST_ROWS", 100)
    with pytest.raises(TracksError, match=r"rows in a group; write it with at most 100"):
        next(TrackFile(file).recordings())


@pytest.mark.parametrize(
    ("name", "values", "kind"),
    [
        ("x", ["long" * 100], "string"),
        ("id", [b"long" * 100], "binary"),
        ("y", [[0.0] * 100], "list<"),
        ("type", [b"car"], "binary"),
        ("crossing", [["none"]], "list<"),
        ("heading", pyarrow.array(["1"]).dictionary_encode(), "dictionary<"),
    ],
)
def test_a_column_that_could_fill_memory_is_not_read(file, tmp_path, name, values, kind):
    """Whatever is written once and stands in many rows; already when the file is opened."""

    def change(table):
        at, column = table.schema.get_field_index(name), pyarrow.array(values)
        return table.set_column(at, name, column.take(pyarrow.array(np.zeros(len(table), int))))

    with pytest.raises(TracksError, match=rf"column {name} holds {kind}.*; make it \w+"):
        _rewritten(file, tmp_path / "large.parquet", change)


@pytest.mark.parametrize(
    ("metadata", "message"),
    [
        ({"jaxwalk": "[1"}, "metadata jaxwalk isn't JSON"),
        ({"jaxwalk": "[1]"}, "metadata jaxwalk isn't an object"),
        ({"jaxwalk_areas": "[" * 20_000}, "metadata jaxwalk_areas isn't JSON"),
    ],
)
def test_damaged_metadata_is_named(file, tmp_path, metadata, message):
    with pytest.raises(TracksError, match=message):
        _rewritten(file, tmp_path / "other.parquet", lambda table: table.replace_schema_metadata(metadata))
