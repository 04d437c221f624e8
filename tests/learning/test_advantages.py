from __future__ import annotations

import jax
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jaxwalk.learning import advantages
from jaxwalk.learning.advantages import Transitions

generalised_advantage, normalised = map(jax.jit, (advantages.generalised_advantage, advantages.normalised))


def floats(*numbers):
    return np.array(numbers, np.float32)


NO = np.zeros(3, bool)
YES = np.ones(3, bool)
REWARD = floats(1, 2, 3)
VALUE = floats(10, 20, 30, 40)


def advantage(terminated=NO, truncated=NO, valid=YES, discount=0.5, gae_lambda=0.5):
    return generalised_advantage(
        Transitions(REWARD, terminated, truncated, valid), VALUE, discount=discount, gae_lambda=gae_lambda
    ).advantage.tolist()


def test_unbroken_by_hand():
    # residuals: 1 + 10 - 10 = 1, 2 + 15 - 20 = -3, 3 + 20 - 30 = -7; each later one counts a quarter
    assert advantage() == [1 - 0.75 - 7 / 16, -3 - 7 / 4, -7]


def test_a_terminated_step_bootstraps_from_nothing_and_starts_anew():
    # step 1 terminates: its residual is 2 - 20; step 2 only restarts
    ends, valid = np.array([False, True, False]), np.array([True, True, False])
    assert advantage(terminated=ends, valid=valid) == [1 - 18 / 4, -18, 0]


def test_a_truncated_step_bootstraps_from_the_final_state():
    # step 1 is cut off: its residual keeps 0.5 x 30, the value of the final state, which step 2 shows
    ends, valid = np.array([False, True, False]), np.array([True, True, False])
    assert advantage(truncated=ends, valid=valid) == [1 - 3 / 4, -3, 0]


def test_an_end_takes_nothing_from_the_step_after_even_if_that_counts():
    ends = np.array([False, True, False])
    assert advantage(terminated=ends) == [1 - 18 / 4, -18, -7]
    assert advantage(truncated=ends) == [1 - 3 / 4, -3, -7]


def test_nothing_flows_over_a_restart_even_if_its_numbers_are_nonsense():
    ends, valid = np.array([False, True, False, False]), np.array([True, True, False, True])
    reward = floats(1, 2, np.nan, 4)
    value = floats(10, 20, 30, 40, 50)
    out = generalised_advantage(Transitions(reward, ends, ~ends & False, valid), value, discount=0.5, gae_lambda=0.5)
    assert out.advantage.tolist() == [1 - 18 / 4, -18, 0, 4 + 25 - 40]


def test_one_agent_terminates_while_another_is_truncated():
    terminated = np.array([[True, False]])[..., None]
    out = generalised_advantage(
        Transitions(np.ones((1, 2, 1), np.float32), terminated, ~terminated, np.ones((1, 1, 1), bool)),
        np.full((2, 2, 1), 10, np.float32), discount=0.5, gae_lambda=0.9,
    )  # fmt: skip
    assert out.advantage.tolist() == [[[-9], [-4]]]


def test_a_decision_lasts_until_the_next_one_by_hand():
    # decided in steps 0 and 2, each worth 10 and 30 there; values elsewhere are never asked
    decided = np.array([True, False, True])
    value = floats(10, np.nan, 30, 40)
    out = generalised_advantage(Transitions(REWARD, NO, NO, YES, decided), value, discount=0.5, gae_lambda=0.1)
    second = 3 + 20 - 30
    first = 1 + 0.5 * 2 + 0.25 * 30 - 10 + 0.1 * 0.25 * second
    np.testing.assert_allclose(np.asarray(out.advantage)[decided], [first, second])
    np.testing.assert_allclose(np.asarray(out.target)[decided], [10 + first, 23])


def test_what_a_step_between_decisions_should_have_expected():
    decided = np.array([True, False, True])
    out = generalised_advantage(Transitions(REWARD, NO, NO, YES, decided), VALUE, discount=0.5, gae_lambda=0.1)
    assert np.asarray(out.target)[1] == pytest.approx(2 + 0.5 * 30 + 0.1 * 0.5 * (3 + 20 - 30))


@pytest.mark.parametrize("ends", ["terminated", "truncated"])
def test_a_decision_ends_with_the_episode(ends):
    # decided in step 0 only; step 1 ends, step 2 shows the final state, worth 30
    no, over = np.zeros(3, bool), np.array([False, True, False])
    flags = {"terminated": no, "truncated": no} | {ends: over}
    out = generalised_advantage(
        Transitions(REWARD, **flags, valid=np.array([True, True, False]), decided=np.array([True, False, True])),
        VALUE, discount=0.5, gae_lambda=1.0,
    )  # fmt: skip
    assert np.asarray(out.advantage)[0] == 1 + 0.5 * 2 + (0.25 * 30 if ends == "truncated" else 0) - 10


numbers = st.sampled_from([2, 5, 12]).flatmap(  # few lengths: each is compiled
    lambda length: st.lists(st.floats(-10, 10, width=32), min_size=length, max_size=length)
)


@settings(max_examples=25, deadline=None)
@given(numbers, st.floats(0, 1))
def test_lambda_zero_is_the_residual(rewards, discount):
    reward, value = floats(*rewards), np.arange(len(rewards) + 1, dtype=np.float32)
    no, yes = np.zeros(len(rewards), bool), np.ones(len(rewards), bool)
    out = generalised_advantage(Transitions(reward, no, no, yes), value, discount=discount, gae_lambda=0.0)
    expected = reward + discount * value[1:] - value[:-1]
    np.testing.assert_allclose(out.advantage, expected, rtol=1e-5, atol=1e-5)


@settings(max_examples=25, deadline=None)
@given(numbers, st.floats(0, 1))
def test_lambda_one_is_the_discounted_return_less_the_value(rewards, discount):
    reward, value = floats(*rewards), np.arange(len(rewards) + 1, dtype=np.float32)
    no, yes = np.zeros(len(rewards), bool), np.ones(len(rewards), bool)
    out = generalised_advantage(Transitions(reward, no, no, yes), value, discount=discount, gae_lambda=1.0)
    returned = float(value[-1])
    for reward_, value_, got in zip(rewards[::-1], value[:-1][::-1], np.asarray(out.advantage)[::-1], strict=True):
        returned = reward_ + discount * returned
        assert float(got) == pytest.approx(returned - float(value_), rel=1e-4, abs=1e-3)


def test_normalised_counts_only_what_has_weight():
    x, weight = floats(0, 6, np.inf, 100), floats(2, 1, 0, 0)
    x = np.where(weight > 0, x, np.float32(0))  # mean 2, variance (2 x 4 + 1 x 16) / 3
    np.testing.assert_allclose(normalised(x, weight), [-(0.5**0.5), 2**0.5, 0, 0], atol=1e-6)
    assert normalised(floats(7), floats(1)).tolist() == [0]
    assert normalised(floats(7, 7, 7, 7), floats(1, 1, 1, 1)).tolist() == [0, 0, 0, 0]


def test_normalised_by_the_deviation_of_something_else():
    # the mean is 2; the unit's is 4, and its variance (2 x 9 + 1 x 36) / 3
    x, weight, unit = floats(0, 6), floats(2, 1), floats(1, 10)
    np.testing.assert_allclose(normalised(x, weight, unit=unit), [-2 / 18**0.5, 4 / 18**0.5], rtol=1e-6)
