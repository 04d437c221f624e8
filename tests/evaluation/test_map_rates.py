"""How episodes end on each of several maps, also where their rows are read from files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from jaxwalk.evaluation.map_rates import rates_by_map
from jaxwalk.evaluation.row_files import RowWriter
from jaxwalk.evaluation.stored_rows import StoredCell, stored_rows
from jaxwalk.metrics import DELAY, OUTCOMES, Rows, measure
from jaxwalk.metrics.delay import Unhindered
from metrics.scenes import random_trajectory

EPISODES = 24
MAPS = np.array(["town", "paper"] * 10 + ["paper"] * 4, object)


@pytest.fixture(scope="module")
def rows():
    found = measure(random_trajectory(1, episodes=EPISODES, frames=20, people=2))
    return replace(found.having(DELAY, Unhindered(np.full(EPISODES, 0.5, np.float32))), maps=MAPS)


def test_each_map_has_its_own_numbers(rows):
    paper, town = rates_by_map(rows)
    table = rows[OUTCOMES]
    here = MAPS == "paper"
    assert (paper.map, town.map, paper.episodes, town.episodes) == ("paper", "town", 14, 10)
    assert paper.goal_rate.value == table.goal[here].mean()
    assert paper.collision_rate.value == table.collision[here].mean()
    times = (table.steps * rows.dt)[here & table.goal]
    assert len(times) > 3
    assert paper.mean_time_to_goal.value == pytest.approx(times.mean())
    assert paper.mean_delay.value == pytest.approx(times.mean() - 0.5)
    assert paper.mean_time_to_goal.low < times.mean() < paper.mean_time_to_goal.high


def test_one_map_or_unknown_ones_have_no_numbers_of_their_own(rows):
    assert rates_by_map(replace(rows, maps=np.full(EPISODES, "paper", object))) == ()
    assert rates_by_map(replace(rows, maps=None)) == ()


def test_rows_of_parts_have_the_same_numbers(rows, tmp_path, monkeypatch):
    for module in ("metrics.statistics", "evaluation.stored_rows"):
        monkeypatch.setattr(f"jaxwalk.{module}.CHUNK", EPISODES)
    with RowWriter(tmp_path) as writer:
        writer.write(0, rows)
        writer.write(0, rows)
    stored = stored_rows([StoredCell(tmp_path, 0, (EPISODES, EPISODES), rows.dt)])
    assert len(list(stored.chunks())) == 2
    assert rates_by_map(stored) == rates_by_map(Rows.join([rows, rows]))
    with pytest.raises(TypeError, match="outcomes of parts is read a chunk at a time"):
        _ = stored[OUTCOMES]
