"""The server of `jaxwalk live`: one page and one socket, on the loopback address, for nobody but its own page.

A browser lets any web page send requests to this machine. So a request must name this server as its host, which it
doesn't after DNS rebinding, and the socket opens only for a page of this server's own origin.
"""

from __future__ import annotations

import json
import logging
import os
import secrets
import socket
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.sync.server import Server, ServerConnection, serve
from websockets.typing import Origin

from jaxwalk.live.live_choice import LONGEST, LiveError, Message, read_message
from jaxwalk.live.live_page import live_page
from jaxwalk.live.live_session import NOBODY_DRIVES, LiveSession

ADDRESS = "127.0.0.1"
SOCKET = "/socket"
"""Path of the socket; that of the page is ``/``."""
QUIET = logging.getLogger("jaxwalk.live.websockets")
QUIET.setLevel(logging.CRITICAL)  # browsers open connections that they don't use, which the library calls failures


def live_server(port: int, make_session: Callable[[], LiveSession]) -> tuple[Server, str]:
    """Return a server, whose ``serve_forever`` serves, and the address of its page.

    Args:
        port: where it listens; 0: any free port.
        make_session: called for each page that is opened.

    Raises:
        LiveError: the port is taken, or this user may not have it.
    """
    try:
        listening = socket.create_server((ADDRESS, port))
    except (OSError, OverflowError) as error:
        why = os.strerror(error.errno) if isinstance(error, OSError) and error.errno else str(error)
        raise LiveError(f"port {port}: {why}; name another one, or 0") from error
    port = listening.getsockname()[1]
    hosts = [f"{name}:{port}" for name in (ADDRESS, "localhost")]
    server = serve(
        lambda connection: _serve_page(connection, make_session()),
        sock=listening,
        origins=[Origin(f"http://{host}") for host in hosts],
        process_request=lambda connection, request: _answer(connection, request, hosts),
        server_header=None,
        compression=None,
        max_size=LONGEST,
        ping_interval=None,  # a page that sleeps is still there when it wakes
        logger=QUIET,
    )
    return server, f"http://{hosts[0]}/"


def _answer(connection: ServerConnection, request: Request, hosts: list[str]) -> Response | None:
    """Return the response to a request; None lets the socket open, if the library finds its origin among ours."""
    named, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
    if len(named) != 1 or named[0] not in hosts:
        return connection.respond(403, "This server answers only by its own name.\n")
    if any(origin not in [f"http://{host}" for host in hosts] for origin in origins):
        return connection.respond(403, "This server answers only its own page.\n")
    if request.method != "GET":
        return connection.respond(405, "This server answers only GET.\n")
    if request.path == SOCKET:
        return None
    if request.path != "/":
        return connection.respond(404, "There is only one page here: /\n")
    return _page(named[0])


def _page(host: str) -> Response:
    """Return the page, which may load and call nothing but this server."""
    once = secrets.token_urlsafe(16)
    body = live_page(once).encode()
    rules = (
        "default-src 'none'", f"script-src 'nonce-{once}'", "style-src 'unsafe-inline'", "img-src data:",
        f"connect-src ws://{host}", "base-uri 'none'", "form-action 'none'", "frame-ancestors 'none'",
    )  # fmt: skip
    headers = {
        "Content-Type": "text/html; charset=utf-8", "Content-Length": str(len(body)), "Connection": "close",
        "Content-Security-Policy": "; ".join(rules), "Cache-Control": "no-store", "Referrer-Policy": "no-referrer",
        "X-Content-Type-Options": "nosniff", "Cross-Origin-Resource-Policy": "same-origin",
        "Cross-Origin-Opener-Policy": "same-origin",
    }  # fmt: skip
    return Response(200, "OK", Headers(headers), body)


def _serve_page(connection: ServerConnection, session: LiveSession) -> None:
    """Play for one page until it is closed."""
    try:
        LivePlay(session, lambda said: connection.send(json.dumps(said, allow_nan=False))).serve(connection.recv)
    except ConnectionClosed:
        return
    except Exception:
        traceback.print_exc()  # a fault of jaxwalk; the page is told that the connection has ended
        raise


class LivePlay:
    """What is said between a page and its session, and the clock: a step is made when its time has come."""

    def __init__(self, session: LiveSession, say: Callable[[dict[str, Any]], None]) -> None:
        """Play a session; ``say`` is called with what the page is told."""
        self._session, self._say = session, say
        self._playing, self._rate, self._due = False, 1.0, 0.0

    def serve(self, receive: Callable[[float | None], str | bytes]) -> None:
        """Do what the page says, and make steps in between, until ``receive`` raises something but TimeoutError.

        ``receive`` is called with the longest time to wait [s]; None: for ever.
        """
        offer = self._session.offer
        lists = {name: getattr(offer, name) for name in ("streets", "worlds", "drivers", "pedestrians", "places")}
        self._say({"kind": "offer", **lists, "kept": len(offer.kept) if offer.kept is not None else None})
        self._told(Message("open", offer.start))
        while True:
            try:
                said = receive(max(0.0, self._due - time.monotonic()) if self._playing else None)
            except TimeoutError:
                self._tick()
            else:
                self._read(said)

    def _read(self, said: str | bytes) -> None:
        try:
            message = read_message(said)
        except LiveError as error:
            self._say({"kind": "problem", "text": str(error)})
        else:
            self._told(message)

    def _told(self, message: Message) -> None:
        with self._problems_told():
            getattr(self, f"_{message.do}")(message)

    @contextmanager
    def _problems_told(self) -> Iterator[None]:
        """Tell the page of errors that jaxwalk or the disk explains; then nothing is playing."""
        try:
            yield
        except (ValueError, OSError) as error:
            if not (isinstance(error, OSError) or type(error).__module__.startswith("jaxwalk")):
                raise
            self._stop()
            self._say({"kind": "problem", "text": " ".join(str(error).split())})

    def _open(self, message: Message) -> None:
        self._say({"kind": "busy"})
        self._say({"kind": "begin", **self._session.open(message.choice or self._session.choice)})
        self._due = time.monotonic() + self._session.dt / self._rate

    def _play(self, message: Message) -> None:
        self._rate, self._playing = message.rate, not self._session.ended
        self._due = time.monotonic()
        self._say({"kind": "playing", "playing": self._playing})

    def _pause(self, message: Message) -> None:
        self._stop()

    def _step(self, message: Message) -> None:
        self._stop()
        if not self._session.ended:
            self._show_step()

    def _hand(self, message: Message) -> None:
        steering = float("nan") if message.steering is None else message.steering
        self._session.hand = (1.0, message.pedal, steering) if message.drives else NOBODY_DRIVES

    def _save(self, message: Message) -> None:
        self._say({"kind": "saved", "path": str(self._session.save())})

    def _tick(self) -> None:
        """Make the step whose time has come. What is late isn't made up for: the street then runs slower."""
        now = time.monotonic()
        self._due = max(self._due + self._session.dt / self._rate, now)
        with self._problems_told():
            self._show_step()

    def _show_step(self) -> None:
        self._say({"kind": "frame", **self._session.step()})
        if self._session.ended:
            self._stop()

    def _stop(self) -> None:
        if self._playing:
            self._playing = False
            self._say({"kind": "playing", "playing": False})
