"""The protocol: what a driver is shown, and what becomes of a wrong answer."""

from __future__ import annotations

import threading

import jax.numpy as jnp
import numpy as np
import pytest

from jaxwalk.policies.host import DriverError, HostDriver
from jaxwalk.policies.host.driver import wrong_action

SEEN = jnp.arange(6.0).reshape(3, 2)  # three features of two episodes


class Doing:
    """A driver whose ``act`` is the given function."""

    def __init__(self, act):
        self.act = act


def hosted(act, **options):
    return HostDriver("mine", Doing(act), observes="paper", **options)


def test_it_is_shown_rows_of_its_own_and_answers_in_rows():
    shown = []

    def act(observation):
        shown.append(observation.copy())
        observation[:] = 0  # it may
        return np.array([[0.5, -1.0], [0, 1.0]])

    action, memory = hosted(act).act(None, None, SEEN)
    assert shown[0].dtype == np.float32
    np.testing.assert_array_equal(shown[0], [[0, 2, 4], [1, 3, 5]])
    np.testing.assert_array_equal(action, [[0.5, 0], [-1, 1]])
    assert memory is None


def test_a_list_or_whole_numbers_will_do():
    action, _ = hosted(lambda observation: [[1, 0], [0, -1]]).act(None, None, SEEN)
    assert action.dtype == jnp.float32
    np.testing.assert_array_equal(action, [[1, 0], [0, -1]])


def test_steps_and_time_are_counted():
    driver = hosted(lambda observation: np.zeros((2, 2)))
    for _ in range(3):
        driver.act(None, None, SEEN)
    assert driver.steps_made == 3
    assert driver.seconds_spent > 0


def _divide(observation):
    return observation[0, 0].item() / 0


def _leave(observation):
    raise SystemExit("enough")


def _interrupt(observation):
    raise KeyboardInterrupt


class _Leaver:
    def __array__(self, *args, **options):
        raise SystemExit(0)


WRONG = {
    "one number": (lambda seen: np.zeros(2), r"mine: act returned shape \(2,\); return an array of shape \(2, 2\)"),
    "turned": (lambda seen: np.zeros((2, 1)), r"shape \(2, 1\)"),
    "nothing": (lambda seen: None, "act returned NoneType of type object"),
    "text": (lambda seen: "left", "act returned str of type <U4"),
    "truth": (lambda seen: np.ones((2, 2), bool), "of type bool"),
    "complex": (lambda seen: np.ones((2, 2), complex), "of type complex128"),
    "ragged": (lambda seen: [[1.0, 2.0], [1.0]], "act returned list, which is no array"),
    "raises": (_divide, r"mine: act raised ZeroDivisionError: .*division by zero \(test_driver.py, line \d+\)"),
    "leaves as it is read": (lambda seen: _Leaver(), "act returned _Leaver, which is no array"),
    "interrupts": (_interrupt, r"mine: act raised KeyboardInterrupt"),
    "leaves": (_leave, r"mine: act raised SystemExit: enough"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_answer_is_one_message_and_the_driver_is_asked_no_more(name):
    act, message = WRONG[name]
    driver = hosted(act)
    with pytest.raises(DriverError, match=message) as first:
        driver.act(None, None, SEEN)
    with pytest.raises(DriverError) as second:
        driver.init((), (2,))
    assert str(second.value) == str(first.value)


def test_one_that_hangs_is_given_up():
    released = threading.Event()
    driver = hosted(lambda observation: released.wait(60), seconds=0.05)
    with pytest.raises(DriverError, match=r"mine: act took longer than 0.05 s; .* --driver-seconds"):
        driver.act(None, None, SEEN)
    assert not released.is_set()
    released.set()


def test_a_driver_need_not_be_told_that_a_batch_begins():
    driver = hosted(lambda observation: np.zeros((2, 2)))
    driver.init((), (2,))
    assert driver.failure is None and driver.steps_made == 0


def test_reset_is_told_how_many_episodes_begin_and_may_fail_too():
    class Remembering:
        def reset(self, episodes):
            self.memory = np.zeros(episodes)

    inner = Remembering()
    HostDriver("mine", inner, observes="paper").init((), (5,))
    assert inner.memory.shape == (5,)
    inner.reset = _leave
    with pytest.raises(DriverError, match="mine: reset raised SystemExit: enough"):
        HostDriver("mine", inner, observes="paper").init((), (5,))
    inner.reset = lambda: None
    with pytest.raises(DriverError, match="mine: reset raised TypeError"):
        HostDriver("mine", inner, observes="paper").init((), (5,))


def test_the_first_impossible_action_of_those_who_play_is_named():
    actions = np.array([[np.nan, 1.0, 0.0, 1.5, 0.0], [0.0, -1.00005, 0.0, 0.0, np.inf]], np.float32)
    everybody = np.ones(5, bool)
    assert wrong_action(actions, everybody)[0] == 0
    episode, what = wrong_action(actions, everybody & (np.arange(5) > 0))
    assert episode == 3  # 1 is above by no more than rounding
    assert "act returned [1.5 0], not 2 numbers in [-1, 1]; clip it" in what
    assert wrong_action(actions, np.arange(5) == 4)[0] == 4
    assert wrong_action(actions, np.arange(5) == 2) is None
