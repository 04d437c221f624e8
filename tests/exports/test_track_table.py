"""Episodes written as trajectories."""

from __future__ import annotations

import pytest

from jaxwalk import Street
from jaxwalk.exports.track_table import SeveralMapsError, record_tracks
from jaxwalk.policies import AlwaysGo, RouteFollower


def test_a_file_has_one_map(tmp_path):
    two = Street.create(["paper", "paper"])
    with pytest.raises(SeveralMapsError, match="choose it with --map"):
        record_tracks(two, RouteFollower(), AlwaysGo(), tmp_path / "t.parquet", episodes=1, seed=0, about={})
    assert list(tmp_path.iterdir()) == []
