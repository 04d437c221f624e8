"""Our own sources of scenarios pass their contract, and whatever breaks one is told in words."""

from __future__ import annotations

import jax
import numpy as np
import pytest

from jaxwalk import Street
from jaxwalk.scenarios import Drawn
from jaxwalk.sim.sim_config import SimConfig
from jaxwalk.testing import ContractError, check_source


def test_our_sources_pass():
    check_source(Drawn(Street.create(config=SimConfig(horizon=2, pedestrians=3)), 3, 6))


keys_of = jax.jit(jax.vmap(jax.random.key))


class Numbers:
    """A source of plain numbers; ``broken`` names what is wrong with it."""

    def __init__(self, broken=""):
        self.broken, self.hashed = broken, 0

    def __len__(self):
        return 6

    def take(self, numbers):
        if self.broken != "range" and ((numbers < 0) | (numbers >= 6)).any():
            raise ValueError("no such number")
        values = numbers + (np.arange(len(numbers)) if self.broken == "place" else 0)
        return jax.device_put(values), keys_of(numbers)

    def hash(self):
        self.hashed += 1
        return "0" * 15 + (str(self.hashed) if self.broken == "hash" else "z" if self.broken == "digits" else "f")

    def describe(self):
        return {"kind": {1} if self.broken == "json" else "numbers"}


@pytest.mark.parametrize(
    ("broken", "message"),
    [
        ("range", r"take: it must raise ValueError for -1, which isn't in \[0, 6\)"),
        ("place", "take: a scenario must not depend on what is taken with it"),
        ("hash", "hash: it must always be the same"),
        ("digits", "hash: it must be 16 hexadecimal digits"),
        ("json", "describe: it must return plain JSON"),
    ],
)
def test_a_broken_source_is_told_what_it_breaks(broken, message):
    check_source(Numbers())
    with pytest.raises(ContractError, match=message):
        check_source(Numbers(broken))
