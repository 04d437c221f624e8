"""Fits whose results are known, and the command that makes them."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys

import numpy as np
import pytest

from experiments.test_real_recordings import GROUND, ROOT, clip, way
from jaxwalk.experiments.people_calibration import car_speed, fit_gap_acceptance, fit_pace, fit_people, why_no_curve
from jaxwalk.experiments.real_recordings import halves, watch_clips
from jaxwalk.formats.clip_grounds import read_clip_grounds
from jaxwalk.formats.tracks import TracksError

ODDS = math.log(3)


def test_the_likeliest_curve_by_hand():
    """One in four accepts 2 s, three in four accept 4 s: the log odds are -ln 3 and ln 3, and 0 at 3 s."""
    gaps, accepted = np.repeat([2.0, 4.0], 4), np.array([1, 0, 0, 0, 1, 1, 1, 0], bool)
    assert fit_gap_acceptance(gaps, accepted) == pytest.approx((3 * ODDS, ODDS), rel=1e-4)


@pytest.mark.parametrize("scale", [1.0, 1e-3, 1e3])
@pytest.mark.parametrize("later", [0.0, 200.0])
def test_the_curve_has_no_favourite_unit_or_origin(scale, later):
    """The log odds are those of the test before, at the gaps as they are here."""
    gaps, accepted = np.repeat([2.0, 4.0], 4) * scale + later, np.array([1, 0, 0, 0, 1, 1, 1, 0], bool)
    intercept, slope = fit_gap_acceptance(gaps, accepted)
    assert slope == pytest.approx(ODDS / scale, rel=1e-4)
    assert intercept / slope == pytest.approx(3 * scale + later)


@pytest.mark.parametrize(
    ("gaps", "accepted", "reason"),
    [
        ([0, 1, 2, 3], [0, 0, 1, 1], "2.00 s parts the 2 accepted ones from the 2 others"),
        ([0, 1, 2, 3], [1, 1, 0, 0], "no longer than others on average \\(0.50 s, 2.50 s"),
        ([0, 1, 2, 3], [1, 1, 1, 1], "everybody accepted one, of 4"),
        ([0, 1, 2, 3], [0, 0, 0, 0], "nobody accepted one, of 4"),
        ([], [], "nobody had a gap to judge"),
        ([1.1, 4.1, 2.1, 3.1], [1, 1, 0, 0], "no longer than others on average \\(2.60 s, 2.60 s"),
        ([1, 5, 2, 3, 9], [1, 1, 0, 0, 0], "no longer than others on average"),
    ],
)
def test_no_finite_curve_that_rises_is_likeliest(gaps, accepted, reason):
    """The last two have a curve, flat or falling: nobody's critical gap."""
    given = np.array(gaps, float), np.array(accepted, bool)
    assert np.isnan(fit_gap_acceptance(*given)).all()
    assert re.search(reason, why_no_curve(*given) or "")


def test_an_even_range_of_speeds_is_found_again():
    assert fit_pace(np.array([1.75, 1.0, 1.5, 1.25]) + 0.125) == pytest.approx((1.0, 2.0))
    assert np.isnan(fit_pace(np.array([1.0]))).all()


def test_people_are_fitted_to_every_second_clip(tmp_path):
    """Accepted: two gaps of 20 m at 5 m/s, one of 20 m at 4 m/s. One who stands declines 4.65 s, two come late."""
    places = "\n".join(f"{name} = {{ turn = 0, scale = 1, move = [0, 0] }}" for name in "acdef")
    (tmp_path / "ground.toml").write_text(f"{GROUND.partition('[clips]')[0]}[clips]\n{places}\n")
    grounds = read_clip_grounds(tmp_path / "ground.toml")
    assert halves(grounds) == (["a", "d", "f"], ["c", "e"])
    clip(tmp_path, "a", [way(-2.0), way(-6.0)])
    clip(tmp_path, "d", [way(-2.5), way(-3.0, stands=(1.0, 5.0))], speed=4.0)
    clip(tmp_path, "f", [way(-2.0), way(-6.0)])
    names, _ = halves(grounds)
    assert car_speed(tmp_path, grounds, names) == pytest.approx(5.0)
    with pytest.raises(TracksError, match=r"fit no curve of accepted gaps: 4\.10 s parts"):
        fit_people(watch_clips(tmp_path, grounds, ["a"]))
    program = [sys.executable, str(ROOT / "docs" / "real_recordings_calibration.py"), str(tmp_path)]
    options = ["--ground", str(tmp_path / "ground.toml"), "--out", str(tmp_path / "out")]
    done = subprocess.run([*program, *options], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "out" / "calibration.json").read_text())
    assert (found["clips"], found["people"]["judged"], found["people"]["accepted"]) == (names, 6, 3)
    seen = found["people"]["approach_seen"]
    assert (seen["judged"], seen["accepted"], seen["critical"]) == (3, 0, None), "three stand at the edge at once"
    assert 0.65 < found["people"]["critical"]["value"] < 5.0
    assert found["people"]["slowest"]["value"] < 1.0 < found["people"]["fastest"]["value"], "one stood on the roadway"
