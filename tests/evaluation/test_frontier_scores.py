"""Who is dominated: fewer contacts and less delay on the same scenarios, by intervals that exclude 0."""

from __future__ import annotations

import math

import numpy as np
import pytest

from jaxwalk.evaluation.frontier_scores import Contender, FrontierScores, FrontierSuite, scores_of_rows, standings
from jaxwalk.metrics import OUTCOMES

SCENARIOS = 400


def driver(name, touched, delay, *, spread=0.5, hidden=False):
    """Contacts in the first scenarios; delays about a mean, the same scenarios being slow for everybody."""
    wobble = spread * np.resize([-1.0, 1.0, 0.0, 0.5, -0.5], SCENARIOS)
    own = 0.01 * np.resize([1.0, -1.0, 0.0], SCENARIOS)  # paired differences vary a little
    delays = tuple(float(x) for x in delay * (1 + own) + wobble)
    contender = Contender(name, name.split()[0], hidden=hidden)
    return FrontierScores(contender, tuple(range(touched)), delays, goals=SCENARIOS - touched, timeouts=0)


def test_a_driver_is_dominated_by_one_that_is_safer_and_quicker():
    hasty, careful, bad = driver("hasty", 80, 1.0), driver("careful", 10, 4.0), driver("bad", 80, 6.0)
    found = standings([hasty, careful, bad])
    assert [one.verdict for one in found] == ["not dominated", "not dominated", "dominated"]
    (beaten,) = found[2].beaten_by
    assert beaten.rival == "careful", "the hasty one has as many contacts"
    assert beaten.contacts.value == pytest.approx(-70 / 400)
    assert beaten.delay.value == pytest.approx(-2.0, abs=1e-3)


def test_the_rival_with_the_fewest_contacts_is_named_first():
    worst = driver("worst", 200, 6.0)
    (*_, found) = standings([driver("good", 40, 2.0), driver("best", 20, 3.0), worst])
    assert [one.rival for one in found.beaten_by] == ["best", "good"]


def test_what_few_scenarios_can_not_tell_is_not_judged():
    """Two contacts fewer of 400 are no difference; nor is a delay that varies as much as it differs."""
    found = standings([driver("a", 3, 2.0), driver("b", 1, 1.9)])
    assert [one.verdict for one in found] == ["cannot be judged", "not dominated"]
    assert found[0].open_against == ("b",) and not found[1].open_against
    same = driver("c", 3, 2.0)
    assert [one.verdict for one in standings([same, same])] == ["cannot be judged"] * 2


def test_the_intervals_of_many_rivals_are_wider():
    """Eight contacts fewer and none the other way: z is 2.8 against one rival, and 3.3 is asked against 50."""
    one, rival = driver("a", 9, 2.0), driver("b", 0, 1.9)
    assert standings([one, rival])[0].verdict == "dominated"
    far = [driver(f"far-{k}", 100, 9.0) for k in range(49)]
    among_many = standings([one, rival, *far])[0]
    assert among_many.verdict == "cannot be judged" and among_many.open_against == ("b",)


def test_who_sees_what_no_car_can_beats_nobody():
    oracle = driver("oracle", 0, 0.5, hidden=True)
    found = standings([driver("a", 80, 2.0), oracle])
    assert [one.verdict for one in found] == ["not dominated", "no real car"]


def test_who_never_arrives_has_no_delay():
    lazy = FrontierScores(Contender("lazy", "lazy"), (), (None,) * SCENARIOS, goals=0, timeouts=SCENARIOS)
    assert lazy.mean_delay().value is None
    assert standings([driver("a", 80, 2.0), lazy])[0].verdict == "cannot be judged"


def test_scores_are_those_of_the_rows(rows):
    found = scores_of_rows(Contender("blind", "blind"), rows)
    ended = rows[OUTCOMES]
    assert found.scenarios == 40
    assert found.goals == ended.goal.sum() and found.goals + found.timeouts + ended.collision.sum() == 40
    assert [x is not None for x in found.delays] == (ended.goal & ~np.isnan(found.seconds())).tolist()
    arrived = found.seconds()[ended.goal]
    assert np.abs(arrived).max() < 1e-3, "the route-follower's own delay is 0"
    assert set(found.touched) <= set(np.flatnonzero(ended.collision))
    assert found.contact_rate().trials == 40 and not math.isnan(found.contact_rate().value)


def test_scores_that_do_not_fit_together_are_refused():
    one = driver("a", 1, 2.0)
    short = FrontierScores(Contender("b", "b"), (), (1.0,), goals=1, timeouts=0)
    with pytest.raises(ValueError, match="b has another number of scenarios than the first driver"):
        FrontierSuite("town", "always-go", "0", (one, short))
    with pytest.raises(ValueError, match="a contact in a scenario that nobody played"):
        FrontierSuite("town", "always-go", "0", (FrontierScores(Contender("b", "b"), (1,), (1.0,), 1, 0),))
