"""``jaxwalk import``, as a user types it."""

from __future__ import annotations

from jaxwalk.cli import main
from maps.imported.osm_files import cross


def test_a_street_is_imported_and_goes_where_the_next_import_has_none(place, capsys):
    cross(sidewalk="no").write(place / "town.osm")
    assert main(["import", "town.osm", "--out", "school.json"]) == 0
    assert "Open school.report.html" in capsys.readouterr().out
    assert (place / "school.json").is_file()
    assert main(["import", "town.osm", "--out", "school.json", "--strict"]) == 1
    assert "not usable" in capsys.readouterr().out
    assert not (place / "school.json").exists(), "the report is about no street"
    assert (place / "school.report.html").is_file()
