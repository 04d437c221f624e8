"""The server answers its own page, and nobody else; what it says, and when it steps."""

from __future__ import annotations

import json
import socket
from http.client import HTTPConnection
from urllib.parse import urlsplit

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from jaxwalk.live.live_choice import LiveError
from jaxwalk.live.live_server import LivePlay, live_server
from live.live_fakes import FakeSession, serving


@pytest.fixture(scope="module")
def served():
    with serving() as served:
        yield served


@pytest.fixture
def address(served):
    return served[1]


def ask(address, path="/", method="GET", **headers):
    """Status, headers and body of a request; ``Host`` is the server's own unless it is given."""
    place = urlsplit(address)
    connection = HTTPConnection(place.hostname, place.port, timeout=10)
    connection.putrequest(method, path, skip_host=True)
    for name, value in {"Host": place.netloc, **headers}.items():
        connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    return answer.status, answer.headers, answer.read().decode()


def test_the_page_may_call_nobody_but_its_server(address):
    status, headers, body = ask(address)
    rules = dict(rule.split(" ", 1) for rule in headers["Content-Security-Policy"].split("; "))
    once = rules["script-src"].removeprefix("'nonce-").removesuffix("'")
    assert (status, rules["default-src"], rules["frame-ancestors"]) == (200, "'none'", "'none'")
    assert rules["connect-src"] == f"ws://{urlsplit(address).netloc}"
    assert f'nonce="{once}"' in body and once not in ask(address)[2]
    assert "http://" not in body and "https://" not in body
    assert "Server" not in headers and headers["Cache-Control"] == "no-store"


def test_its_name_is_the_loopback_address_or_localhost(address):
    port = urlsplit(address).port
    assert ask(address, Host=f"localhost:{port}")[0] == 200
    for host in (
        f"evil.example:{port}",
        "evil.example",
        "127.0.0.1",
        "localhost",
        f"127.0.0.1:{port + 1}",
        "",
        f"[::1]:{port}",
    ):
        assert ask(address, Host=host)[0] == 403, host


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://127.0.0.1", "http://127.0.0.1"])
def test_pages_of_other_origins_are_refused(address, origin):
    assert ask(address, Origin=origin)[0] == 403
    with pytest.raises(InvalidStatus, match="403"):
        connect(f"ws://{urlsplit(address).netloc}/socket", origin=origin)


def test_a_socket_without_an_origin_is_refused(address):
    with pytest.raises(InvalidStatus, match="403"):
        connect(f"ws://{urlsplit(address).netloc}/socket")


def test_a_socket_after_dns_rebinding_is_refused(address):
    port = urlsplit(address).port
    here = socket.create_connection(("127.0.0.1", port))
    with pytest.raises(InvalidStatus, match="403"):
        connect(f"ws://evil.example:{port}/socket", sock=here, origin=f"http://evil.example:{port}")


@pytest.mark.parametrize(
    "path", ["/etc/passwd", "/../../etc/passwd", "/%2e%2e/x", "/live.js", "/socket/", "//", "/?x=1"]
)
def test_there_is_no_other_file(address, path):
    assert ask(address, path)[0] == 404


def test_only_get_is_understood(address):
    assert ask(address, method="POST")[0] == 405


def test_it_listens_on_the_loopback_address_alone(served):
    host, taken = served[0].socket.getsockname()
    assert host == "127.0.0.1"
    with pytest.raises(LiveError, match=f"port {taken}: .*name another one"):
        live_server(taken, FakeSession)


def test_a_page_plays(address):
    with connect(f"ws://{urlsplit(address).netloc}/socket", origin=address.rstrip("/")) as page:
        said = [json.loads(page.recv(10)) for _ in range(3)]
        assert [one["kind"] for one in said] == ["offer", "busy", "begin"]
        assert said[0]["streets"]["paper"] == "paper"
        page.send(json.dumps({"do": "play", "rate": 8.0}))
        said = [json.loads(page.recv(10)) for _ in range(5)]
    assert said == [
        {"kind": "playing", "playing": True}, *({"kind": "frame", "step": k} for k in (1, 2, 3)),
        {"kind": "playing", "playing": False},
    ]  # fmt: skip


class Talk:
    """What a page says, one after the other; None: nothing, so that the time of a step comes."""

    def __init__(self, *said):
        self.said, self.heard, self.waits, self.session = list(said), [], [], FakeSession()

    def receive(self, wait):
        self.waits.append(wait)
        if not self.said:
            raise EOFError
        said = self.said.pop(0)
        if said is None:
            raise TimeoutError
        return said if isinstance(said, str) else json.dumps(said)

    def kinds(self):
        with pytest.raises(EOFError):
            LivePlay(self.session, self.heard.append).serve(self.receive)
        return [one["kind"] for one in self.heard[3:]]


def test_a_step_pauses():
    assert Talk({"do": "play"}, {"do": "step"}, {"do": "step"}).kinds() == ["playing", "playing", "frame", "frame"]


def test_nothing_is_stepped_after_the_end():
    talk = Talk({"do": "play"}, None, None, None, {"do": "step"}, {"do": "play"})
    assert talk.kinds() == ["playing", "frame", "frame", "frame", "playing", "playing"]
    assert talk.heard[-1]["playing"] is False
    assert talk.waits[-1] is None


def test_a_faster_clock_waits_for_less():
    talk = Talk({"do": "play", "rate": 4.0}, None)
    talk.kinds()
    assert talk.waits[0] is None
    assert 0 < talk.waits[-1] <= 0.1 / 4


def test_the_hand_drives_until_it_gives_the_car_back():
    talk = Talk({"do": "hand", "drives": True, "pedal": -1, "steering": 0.4})
    talk.kinds()
    assert talk.session.hand == (1.0, -1.0, 0.4)
    talk = Talk({"do": "hand", "drives": True}, {"do": "hand"})
    talk.kinds()
    assert talk.session.hand[0] == 0


@pytest.mark.parametrize(
    "said",
    [
        "", "[]", "{}", '{"do": "format"}', '{"do": "hand", "pedal": NaN}', '{"do": "hand", "pedal": 7}',
        '{"do": "play", "rate": 1e9}', '{"do": "save", "path": "/etc/passwd"}', '{"do": "open", "choice": {}}',
    ],
)  # fmt: skip
def test_a_message_that_is_none_is_a_problem(said):
    talk = Talk(said)
    assert talk.kinds() == ["problem"]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("street", "/etc/passwd"),
        ("driver", "/tmp/mine.py:Mine"),
        ("pedestrians", "x"),
        ("world", "test-track"),
        ("places", 1000),
    ],
)
def test_what_is_not_offered_is_not_loaded(name, value):
    choice = {"street": "paper", "world": "paper", "places": 12, "driver": "route-follower", "pedestrians": "always-go"}
    talk = Talk({"do": "open", "choice": {**choice, name: value}})
    assert talk.kinds() == ["busy", "problem"]
    assert talk.heard[-1]["text"].startswith(f"{name}: ")


def test_a_full_disk_is_a_problem(monkeypatch):
    talk = Talk({"do": "play"}, {"do": "save"}, {"do": "step"})
    monkeypatch.setattr(talk.session, "save", lambda: (_ for _ in ()).throw(OSError(28, "No space left on device")))
    assert talk.kinds() == ["playing", "playing", "problem", "frame"]


def test_a_fault_of_ours_is_none():
    talk = Talk({"do": "step"})
    talk.session.step = lambda: int("x")
    with pytest.raises(ValueError, match="invalid literal"):
        LivePlay(talk.session, talk.heard.append).serve(talk.receive)
