"""The check of docs/real-streets.md: its own reading of OpenDRIVE, without netconvert."""

from importlib import import_module
from pathlib import Path

import numpy as np

from maps.imported.drive_files import LANE, LENGTH, drive_file


def test_a_lane_ends_where_a_section_does(tmp_path, monkeypatch):
    """In the second half of the road not lane -1 is for cars but lane -2: no line leads over from one to the next."""
    monkeypatch.syspath_prepend(Path(__file__).parents[3] / "docs")
    check = import_module("lane_lines_check")
    text = drive_file("")
    begin, end = text.index("<laneSection"), text.index("</laneSection>") + len("</laneSection>")
    first = text[begin:end]
    right = first[first.index("<right>") :]
    moved = right.replace('"-1" type="driving"', '"-1" type="x"').replace('"-2" type="sidewalk"', '"-2" type="driving"')
    second = first.replace(right, moved).replace('s="0"', 's="120"')
    path = tmp_path / "road.xodr"
    path.write_text(text[:end] + second + text[end:], encoding="utf-8")
    lines = check._of_opendrive(path)
    found = sorted((round(line.coords[0][0]), round(line.coords[-1][0]), line.bounds[1]) for line in lines)
    assert [one[:2] for one in found] == [(0, 120), (120, 0), (120, 240), (240, 120)]
    np.testing.assert_allclose([one[2] - 50 for one in found], [-LANE / 2, LANE / 2, -LANE - 1, LANE / 2], atol=1e-6)
    assert all(line.bounds[1] == line.bounds[3] for line in lines) and LENGTH == 240
