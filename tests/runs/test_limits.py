"""Trainings on a street whose costs have limits."""

from __future__ import annotations

from dataclasses import replace

import pytest

from jaxwalk.learning.config import CostLimit
from jaxwalk.recipes import single_agent, with_training
from jaxwalk.runs.folder import Run
from jaxwalk.runs.progress import Display
from jaxwalk.runs.session import Session
from jaxwalk.runs.street import WorldError, make_street
from jaxwalk.runs.training import train_in

LIMITS = (CostLimit("contact", limit=0.01, worth=15.0), CostLimit("impact_speed", limit=2.0, tail=0.99, worth=0.02))


def limited(experiment, *limits, role="driver"):
    """The experiment with limits of a role."""
    roles = experiment.train.roles
    return with_training(experiment, roles=roles | {role: replace(roles[role], limits=limits)})


def test_a_street_counts_what_has_a_limit(tiny):
    assert make_street(tiny).costs == ()
    assert make_street(limited(tiny, *LIMITS)).costs == ("contact", "impact_speed")


def test_limits_that_the_street_cannot_keep_are_refused(tiny):
    with pytest.raises(WorldError, match=r"train\.roles\.driver\.limits must be one of contact, .*, not 'noise'"):
        make_street(limited(tiny, CostLimit("noise", limit=1.0)))
    with pytest.raises(WorldError, match=r"train\.roles\.pedestrian\.limits must be one of none, not 'contact'"):
        make_street(limited(tiny, LIMITS[0], role="pedestrian"))
    with pytest.raises(WorldError, match=r"train\.roles\.driver\.limits: tail must be 0 but for contact, impact_speed"):
        make_street(limited(tiny, CostLimit("critical_time", limit=1.0, tail=0.9)))


@pytest.mark.long
def test_a_resumed_training_with_limits_equals_an_uninterrupted_one(tiny, tmp_path, quiet, monkeypatch):
    """The files of run folders hold limits, multipliers and thresholds."""
    experiment = single_agent(limited(tiny, *LIMITS))
    whole = Run.create(tmp_path / "whole", experiment)
    train_in(whole, display=Display(quiet))

    record = Session.record

    def record_and_stop(self, metrics, updates, before):
        record(self, metrics, updates, before)
        self.stop.requested |= updates == 2

    monkeypatch.setattr(Session, "record", record_and_stop)
    cut = Run.create(tmp_path / "cut", experiment)
    assert train_in(cut, display=Display(quiet)).interrupted
    monkeypatch.undo()
    cut = Run.open(cut.path)
    assert cut.experiment.train.roles["driver"].limits == LIMITS
    assert not train_in(cut, resume=True, display=Display(quiet)).interrupted
    assert cut.policy.read_bytes() == whole.policy.read_bytes()
    told = [[{**line, "seconds": 0} for line in run.metrics()] for run in (whole, cut)]
    assert told[0] == told[1]
    last = told[0][-1]
    assert {"cost/driver/contact", "multiplier/driver/contact", "threshold/driver/impact_speed"} <= last.keys()
    assert "driver contact/critic_loss" in last
    assert "threshold/driver/contact" not in last
