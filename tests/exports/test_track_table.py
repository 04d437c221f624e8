"""Episodes written as trajectories."""

from __future__ import annotations

import pytest

from jaxwalk import Street
from jaxwalk.exports.track_table import SeveralMapsError, record_tracks
from jaxwalk.policies import AlwaysGo, RouteFollower
from jaxwalk.scenarios import Drawn


def test_a_file_has_one_map(tmp_path):
    two = Street.create(["paper", "paper"])
    with pytest.raises(SeveralMapsError, match="choose it with --map"):
        cast = {"driver": RouteFollower(), "pedestrian": AlwaysGo()}
        record_tracks(two, cast, Drawn(two, 0, 1), tmp_path / "t.parquet", about={})
    assert list(tmp_path.iterdir()) == []
