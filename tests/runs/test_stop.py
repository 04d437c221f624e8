"""Ctrl-C and other signals during a training."""

import signal
import threading

import pytest

from jaxwalk.runs.stop import ENDING, HANGUP, Stop


@pytest.mark.parametrize("number", ENDING)
def test_the_first_asks_and_the_second_interrupts(number):
    before = {each: signal.getsignal(each) for each in ENDING}
    with Stop().listening() as stop:
        assert not stop.requested and not stop.heard
        signal.raise_signal(number)
        assert stop.requested and stop.heard
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert {each: signal.getsignal(each) for each in ENDING} == before


@pytest.mark.skipif(HANGUP is None, reason="POSIX")
def test_a_terminal_that_hangs_up_twice_interrupts_nothing():
    with Stop().listening() as stop:
        signal.raise_signal(HANGUP)
        signal.raise_signal(HANGUP)
        assert stop.requested


@pytest.mark.skipif(HANGUP is None, reason="POSIX")
def test_what_the_process_ignores_stays_ignored():
    before = signal.signal(HANGUP, signal.SIG_IGN)
    try:
        with Stop().listening() as stop:
            signal.raise_signal(HANGUP)
            assert not stop.requested
    finally:
        signal.signal(HANGUP, before)


def test_other_threads_leave_ctrl_c_to_the_main_one():
    seen = []

    def listen():
        with Stop().listening():
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=listen)
    thread.start()
    thread.join()
    assert seen == [signal.getsignal(signal.SIGINT)]
