"""What a source of scenarios must do, so that evaluations can address, hash and replay its scenarios."""

from __future__ import annotations

import json

import numpy as np

from jaxwalk.scenarios.source import HASH_DIGITS, Source
from jaxwalk.testing.requirement import ContractError, episode, require, same


def check_source(source: Source) -> None:
    """Take scenarios of a source in several ways, and check everything that others rely on.

    Raises:
        ContractError: something doesn't hold; the message says what.
    """
    count = len(source)
    require(count >= 1, "len: a source has at least one scenario")
    numbers = np.arange(4) % count
    scenarios, keys = source.take(numbers)
    require(keys.shape == (4,), f"take: it must return a key for each number: shape (4,), not {keys.shape}")
    require(same((scenarios, keys), source.take(numbers)), "take: equal numbers must give equal scenarios and keys")
    turned, turned_keys = source.take(numbers[::-1])
    message = "take: a scenario must not depend on what is taken with it, or on its place"
    for place in range(4):
        one = (episode(scenarios, place), episode(keys, place))
        require(same(one, (episode(turned, 3 - place), episode(turned_keys, 3 - place))), message)
    for wrong in (-1, count):
        _check_refused(source, wrong)
    digest = source.hash()
    require(digest == source.hash(), "hash: it must always be the same")
    hexadecimal = len(digest) == HASH_DIGITS and all(digit in "0123456789abcdef" for digit in digest)
    require(hexadecimal, f"hash: it must be {HASH_DIGITS} hexadecimal digits, not {digest!r}")
    try:
        json.dumps(source.describe(), allow_nan=False)
    except (TypeError, ValueError) as error:
        raise ContractError(f"describe: it must return plain JSON ({error})") from error


def _check_refused(source: Source, number: int) -> None:
    try:
        source.take(np.array([number]))
    except ValueError:
        return
    raise ContractError(f"take: it must raise ValueError for {number}, which isn't in [0, {len(source)})")
