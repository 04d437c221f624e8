"""The Parquet file of encounters, as somebody with pyarrow reads it."""

from __future__ import annotations

import numpy as np
import pyarrow.parquet as parquet
import pytest

from jaxwalk.evaluation import check_parquet, write_encounters
from jaxwalk.metrics import ENCOUNTERS, SURROGATES


def test_every_encounter_has_its_row(rows, tmp_path):
    path = tmp_path / "encounters.parquet"
    write_encounters(path, [("route-follower", "undecided", 0.25, rows), ("again", "undecided", 0.25, rows)])
    table = parquet.read_table(path)
    one = len(rows[ENCOUNTERS].type)
    assert table.num_rows == 2 * one
    assert [path.name for path in tmp_path.iterdir()] == ["encounters.parquet"]
    columns = {name: table.column(name).to_pylist()[:one] for name in table.column_names}
    assert set(columns["type"]) <= {"crosswalk", "jaywalk"} and set(columns["driver"]) == {"route-follower"}
    np.testing.assert_array_equal(columns["scenario"], rows[ENCOUNTERS].scenario)
    np.testing.assert_allclose(columns["start"], rows[ENCOUNTERS].start * 0.1)
    assert [value is None for value in columns["pet"]] == np.isnan(rows[SURROGATES].pet).tolist()
    assert table.schema.field("drac").metadata == {b"unit": b"m/s2"}
    assert table.schema.field("type").metadata is None


def test_without_pyarrow_the_message_names_the_extra(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(ValueError, match=r'pip install "jaxwalk\[data\]"'):
        check_parquet()
