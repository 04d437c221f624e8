"""A training in which a process hangs ends."""

import time

from jaxwalk.runs.watchdog import Watchdog


def _waited(happened, seconds=20.0):
    until = time.monotonic() + seconds
    while not happened() and time.monotonic() < until:
        time.sleep(0.01)
    return happened()


def test_no_update_for_long_ends_it():
    ends = []
    with Watchdog(ends.append, least=0.2) as watchdog:
        watchdog.finished()
        watchdog.finished()
        assert _waited(lambda: ends)
    assert ends[0] >= 0.2


def test_the_first_two_updates_may_take_any_time():
    ends = []
    with Watchdog(ends.append, least=0.01) as watchdog:
        time.sleep(0.1)
        watchdog.finished()
        time.sleep(0.1)
    assert not ends


def test_slow_updates_have_more_time():
    ends = []
    with Watchdog(ends.append, least=0.01) as watchdog:
        watchdog.finished()
        time.sleep(0.2)
        watchdog.finished()
        time.sleep(0.5)  # 20 times as long as the longest one would be 4 s
    assert not ends


def test_a_training_that_is_over_is_left_alone():
    ends = []
    with Watchdog(ends.append, least=0.1) as watchdog:
        watchdog.finished()
        watchdog.finished()
    time.sleep(0.3)
    assert not ends
