"""A session without a simulation, for tests of the server and of what is said over its socket."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from threading import Thread

from jaxwalk.live.live_choice import LiveChoice
from jaxwalk.live.live_offer import offer_of
from jaxwalk.live.live_server import live_server
from jaxwalk.live.live_session import NOBODY_DRIVES, LiveSession
from jaxwalk.sim.suites import Where

START = LiveChoice("paper", "paper", 12, "route-follower", "always-go")


class FakeSession(LiveSession):
    """Ends after three steps."""

    dt = 0.1

    def __init__(self):
        self.offer = offer_of(["route-follower"], ["always-go"], Where())
        self.choice, self.hand, self.steps = START, NOBODY_DRIVES, 0

    @property
    def ended(self):
        return self.steps >= 3

    def open(self, choice):
        self.offer.check(choice)
        self.choice, self.steps = choice, 0
        return {"number": choice.number}

    def step(self):
        self.steps += 1
        return {"step": self.steps}

    def save(self):
        return Path("saved.safetensors")


@contextmanager
def serving(make_session=FakeSession):
    """Serves meanwhile; yields the server and the address of its page."""
    server, address = live_server(0, make_session)
    with server:
        thread = Thread(target=server.serve_forever)
        thread.start()
        yield server, address
    thread.join()
