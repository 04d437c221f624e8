"""The error of a training by several processes that has lost one of them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from jaxwalk.runs.folder import RunError

CONNECTION = ("Gloo", "NCCL", "coordination service", "CoordinationService")
"""Words of JAX's errors about the connection between processes."""


class PeerLostError(RunError):
    """Another process of the training ended, or can't be reached any more."""


@contextmanager
def explaining_lost_peers() -> Iterator[None]:
    """Raise PeerLostError for an error of the connection to another process. JAX raises many kinds."""
    try:
        yield
    except (ValueError, RuntimeError) as error:
        if not any(word in str(error) for word in CONNECTION):
            raise
        raise PeerLostError(
            "another process of the training ended, or can't be reached any more; start all again"
        ) from error
