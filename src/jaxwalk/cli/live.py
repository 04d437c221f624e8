"""``jaxwalk live``."""

from __future__ import annotations

import threading
import webbrowser
from collections.abc import Callable
from contextlib import closing
from functools import partial
from importlib.util import find_spec

from jaxwalk.cli.checks import check_count, check_driver_seconds, check_kept, check_seed
from jaxwalk.cli.errors import UsageError
from jaxwalk.cli.options import Live
from jaxwalk.live.live_offer import offer_of
from jaxwalk.live.live_session import LiveSession
from jaxwalk.maps import each_map
from jaxwalk.runs.contestants import contestant
from jaxwalk.runs.folder import check_writable
from jaxwalk.scenarios.archive_file import read_archive
from jaxwalk.sim.suites import Where

LONGEST = 525_600.0
"""Longest time that a server can be told to run [minutes]: a year."""


def run(options: Live) -> int:
    """Serve the page until Ctrl-C, or for the time that was asked for."""
    check(options)
    kept = read_archive(options.scenarios) if options.scenarios else None
    where = Where(each_map(options.map), options.world, options.people)
    offer = offer_of(options.driver, options.pedestrians, where, seed=options.seed, kept=kept)
    load = partial(contestant, trust=options.trust, seconds=options.driver_seconds)
    serve_pages(options, lambda: LiveSession(offer, options.out, load))
    return 0


def serve_pages(options: Live, make_session: Callable[[], LiveSession]) -> None:
    """Serve until Ctrl-C, or for the time that was asked for."""
    from jaxwalk.live.live_server import live_server

    server, address = live_server(options.port, make_session)
    with closing(server.socket):  # a server that doesn't serve yet can't be shut down
        print(f"Open {address} in a browser of this machine; Ctrl-C ends the server", flush=True)
        if options.open:
            webbrowser.open(address)
        if options.minutes is not None:
            timer = threading.Timer(60 * options.minutes, server.shutdown)
            timer.daemon = True
            timer.start()
        with server:
            server.serve_forever()


def check(options: Live) -> None:
    """Raise an error for impossible options."""
    check_seed(options.seed)
    check_count("--port", options.port, 0, 65_535)
    check_driver_seconds(options.driver_seconds)
    if options.minutes is not None and not 0 < options.minutes <= LONGEST:
        raise UsageError(f"--minutes must be above 0 and at most {LONGEST:,.0f}, not {options.minutes:g}")
    if options.scenarios:
        check_kept(options)
    check_writable(options.out)
    if find_spec("websockets") is None:
        raise UsageError("`jaxwalk live` needs `pip install 'jaxwalk[live]'`")
