"""Standings: which results can stand in a leaderboard."""

from __future__ import annotations

import dataclasses

import pytest

from jaxwalk.evaluation.document_parts import PolicyOrigin, StreetOrigin
from jaxwalk.metrics.contacts import MEASURED_CONTACTS
from jaxwalk.report.leaderboard import StandingsError, standings
from jaxwalk.sim.sim_config import SimConfig
from report.material import material


@pytest.fixture(scope="module")
def results():
    """Results of one driver among one population."""
    (cell, *_), found = (given := material(1).results).cells, given
    return dataclasses.replace(
        found,
        cells=(cell,),
        street=StreetOrigin((), SimConfig()),
        drivers=(PolicyOrigin(cell.driver, "rule", None),),
        populations=(PolicyOrigin(cell.pedestrians, "rule", None),),
    )


def test_a_cell_is_a_line(results):
    (line,) = standings("mine", results, checked=True)
    contacts = results.cells[0].summary[MEASURED_CONTACTS].footprint.moving.value
    assert (line.entry, line.contacts, line.crowd, line.street) == (
        "mine", contacts, results.populations[0], results.street,
    )  # fmt: skip
    assert line.rank[:2] == (False, contacts)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"street": None}, "have no rules"),
        ({"cells": ()}, "have no cells"),
        ({"populations": ()}, "a cell of its results is not of their driver and populations"),
        ({"drivers": (PolicyOrigin("another", "rule", None),)}, "a cell of its results is not of their driver"),
    ],
)
def test_results_that_cannot_stand_in_it_are_refused(results, change, said):
    with pytest.raises(StandingsError, match=f"^mine: .*{said}"):
        standings("mine", dataclasses.replace(results, **change), checked=False)
