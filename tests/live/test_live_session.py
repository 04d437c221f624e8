"""A scenario played live is the one that is saved, whoever drives and however dials were turned before."""

from __future__ import annotations

import json
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from jaxwalk.evaluation import play
from jaxwalk.evaluation.playing import play_block
from jaxwalk.live import live_session
from jaxwalk.live.live_choice import LiveError, read_message
from jaxwalk.live.live_frames import moment_record
from jaxwalk.live.live_offer import FROM_FILE, offer_of
from jaxwalk.live.live_session import NOBODY_DRIVES, LiveSession, _with_rule, street_of
from jaxwalk.policies import AlwaysGo, RouteFollower
from jaxwalk.runs.contestants import contestant
from jaxwalk.scenarios import Drawn
from jaxwalk.scenarios.archive_file import read_archive, write_archive
from jaxwalk.sim.suites import Where
from live.live_fakes import START

MIDDLE = replace(START, seed=5, number=2)
FULL_THROTTLE, FULL_BRAKING = (1.0, 1.0, float("nan")), (1.0, -1.0, float("nan"))


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    offer = offer_of(["route-follower"], ["always-go"], Where())
    return LiveSession(offer, tmp_path_factory.mktemp("live") / "saved", contestant)


def played(session, choice, hand=None, steps=30):
    """The first frames of a scenario, but none after its end."""
    begun = session.open(choice)
    if hand:
        session.hand = hand
    frames = [begun["frame"]]
    while not session.ended and len(frames) <= steps:
        frames.append(session.step())
    session.hand = NOBODY_DRIVES
    return frames


def places(frames):
    return np.array([[frame["car"][:2], *(person[:2] for person in frame["people"])] for frame in frames])


def test_what_is_saved_is_what_was_played(session):
    frames = played(session, replace(MIDDLE, jaywalk_multiplier=1.5, people=9, max_speed=6.5), steps=300)
    path = session.save()
    kept = read_archive(path)
    assert session.save().name == f"{path.stem}-2.safetensors"
    assert kept.street.config.max_speed == 6.5 and kept.street.config.jaywalk_multiplier == 1.5
    scenarios, keys = kept.take(np.array([0]))
    policies = {"driver": RouteFollower(), "pedestrian": AlwaysGo()}
    again = play(kept.street, policies, scenarios, keys)
    seen = places(frames)
    assert again.length[0] == len(frames) - 1
    assert frames[-1]["ending"] == ("collision" if again.collision[0] else "goal" if again.goal[0] else "timeout")
    np.testing.assert_allclose(seen[:, 0], np.stack([again.car_x[:, 0], again.car_y[:, 0]], axis=1), atol=0.006)
    np.testing.assert_allclose(seen[:, 1:, 0], again.ped_x[:, 0], atol=0.006)
    assert (seen[:, 10:] < -400).all()  # three are not there


def test_turning_dials_compiles_nothing_and_is_not_remembered(session):
    usual = played(session, MIDDLE)
    compiled = play_block._cached._cache_size()
    slow = played(session, replace(MIDDLE, max_speed=3.0, jaywalk_multiplier=2.0, people=0))
    assert max(frame["car"][3] for frame in slow) == pytest.approx(3.0)
    assert play_block._cached._cache_size() == compiled
    assert played(session, MIDDLE) == usual
    assert session.choice.max_speed == 8.33 and session.choice.people == 12


def test_who_drives_by_hand_meets_the_same_people(session):
    usual = played(session, MIDDLE)
    assert played(session, MIDDLE, FULL_THROTTLE) == usual  # as the route-follower drives
    session.open(MIDDLE)
    session.hand = FULL_BRAKING
    standing = [session.step() for _ in range(10)]
    session.hand = NOBODY_DRIVES
    assert [frame["car"][3] for frame in standing] == [0.0] * 10
    assert [frame["people"] for frame in standing] == [frame["people"] for frame in usual[1:11]]
    assert session.step()["car"][3] > 0  # the driver goes on from where the hand left the car


def test_a_hand_that_steers_leaves_the_route(session):
    session.open(MIDDLE)
    session.hand = (1.0, 1.0, 0.4)
    turned = [session.step()["car"][2] for _ in range(20)]
    session.hand = NOBODY_DRIVES
    assert turned[-1] - turned[0] > 0.3


def test_a_scenario_is_that_of_the_seed_and_the_number():
    street = street_of("paper", "paper", 12)
    drawn = Drawn(street, 5, 3)
    taken, _ = drawn.take(np.array([2]))
    from jaxwalk.scenarios.archived import scenarios_at

    kept = scenarios_at(street, drawn.points(np.array([2])))
    for name in ("route", "start", "goals", "traits", "jaywalk_draw", "zone_draw"):
        np.testing.assert_array_equal(getattr(taken, name), getattr(kept, name))


def test_a_failed_choice_leaves_the_scenario_as_it_was(session):
    session.open(MIDDLE)
    first = session.step()
    with pytest.raises(LiveError, match="street: 'nowhere' isn't offered"):
        session.open(replace(MIDDLE, street="nowhere"))
    assert not session.ended
    session.step()
    session.open(MIDDLE)
    assert session.step() == first


def test_a_file_of_scenarios_decides_where(session, tmp_path):
    session.open(replace(MIDDLE, people=7))
    kept = read_archive(session.save())
    offer = offer_of([], [], Where(), kept=kept)
    assert (offer.start.world, offer.start.places, list(offer.streets)) == (FROM_FILE, 12, ["paper"])
    other = LiveSession(offer, tmp_path, contestant)
    with pytest.raises(LiveError, match="the file has scenarios 0 to 0"):
        other.open(replace(offer.start, number=1))
    _, source = other._dialled(offer.start)
    assert source.present.sum() == 7
    assert (source.seed, source.keys.tolist()) == (5, [2])


def _kept_of(session, present, **rules):
    """A file's scenario with these people alone, on a street with other numbers for some rules."""
    session.open(MIDDLE)
    kept = session._source
    street = kept.street
    for name, value in rules.items():
        street = _with_rule(street, name, value)
    return replace(kept, street=street, present=np.isin(np.arange(12), present)[None])


def test_who_is_left_out_of_a_file_stays_out(session, tmp_path):
    offer = offer_of([], [], Where(), kept=_kept_of(session, [3, 7, 8]))
    other = LiveSession(offer, tmp_path, contestant)
    for people, there in ((None, [3, 7, 8]), (3, [3, 7, 8]), (2, [3, 7]), (12, [3, 7, 8]), (0, [])):
        _, source = other._dialled(replace(offer.start, people=people))
        assert np.flatnonzero(source.present[0]).tolist() == there


def test_dials_reach_to_the_numbers_of_a_file(session, tmp_path):
    offer = offer_of(["route-follower"], ["always-go"], Where(), kept=_kept_of(session, [1], max_speed=35.0))
    other = LiveSession(offer, tmp_path, contestant)
    begun = other.open(offer.start)
    assert (begun["choice"]["max_speed"], begun["choice"]["people"], begun["most"]) == (35.0, 1, 1)
    again = read_message(json.dumps({"do": "open", "choice": begun["choice"]})).choice
    assert other.open(again)["choice"] == begun["choice"]
    for choice in (replace(offer.start, max_speed=36.0), replace(offer.start, jaywalk_multiplier=11.0)):
        with pytest.raises(LiveError, match="must be"):
            other.open(choice)
    with pytest.raises(LiveError, match="max_speed: must be 1 to 30, not 35"):
        session.open(replace(MIDDLE, max_speed=35.0))


def test_pages_that_save_at_once_have_files_of_their_own(session, monkeypatch):
    session.open(MIDDLE)
    others = [LiveSession(session.offer, session._folder / "at-once", contestant) for _ in range(3)]
    for other in others:
        other.choice, other._source = session.choice, session._source
    monkeypatch.setattr(live_session, "write_archive", lambda *args: (time.sleep(0.05), write_archive(*args)))
    with ThreadPoolExecutor() as pool:
        paths = list(pool.map(LiveSession.save, others))
    assert len(set(paths)) == 3 and all(len(read_archive(path)) == 1 for path in paths)


def test_who_is_lost_from_sight_has_the_place_where_they_were_last_seen():
    people = np.array([[1.0], [2.0]])
    flags = np.array([[True], [True]])
    frame = {
        "car_x": np.array([5.0]), "car_y": np.array([6.0]), "car_cos": np.array([0.0]), "car_sin": np.array([1.0]),
        "car_speed": np.array([2.0]), "car_acceleration": np.array([-3.0]), "ped_x": people, "ped_y": people + 10,
        "going": flags, "on_roadway": ~flags, "crossing": np.zeros((2, 1), int),
        "perceived": np.array([[True], [False]]),
        "last_seen_x": people - 0.5, "last_seen_y": people + 9,
    }  # fmt: skip
    shown = moment_record(frame, np.array([[True], [True]]))
    assert shown["car"] == [5.0, 6.0, 1.571, 2.0, -3.0]
    assert shown["people"] == [[1.0, 11.0, 1], [2.0, 12.0, 9, 1.5, 11.0]]
    assert moment_record(frame, np.array([[True], [False]]))["people"][1] == [2.0, 12.0, 9]
