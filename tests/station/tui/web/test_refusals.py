"""Whom the web server answers: its own page on this machine, and nobody else."""

import socket
from collections.abc import Iterator, Mapping
from http.client import HTTPConnection
from urllib.parse import quote, urlsplit

import pytest

from station.tui.web import PortTaken, serve
from tests.patience import HANG_S
from tests.station.tui.web.engine import WebServer

UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==",
}
PARTS = [("", 200, {}), ("ws", 101, UPGRADE), ("static/js/textual.js", 200, {})]  # path, status, headers


@pytest.fixture(scope="module")
def web() -> Iterator[WebServer]:
    with WebServer(["true"]) as made:
        yield made


def answer(web: WebServer, path: str, headers: Mapping[str, str]) -> int:
    """Return the status of the answer to a request."""
    connection = HTTPConnection(urlsplit(web.url).netloc, timeout=HANG_S)
    connection.request("GET", path, headers=headers)
    status = connection.getresponse().status
    connection.close()
    return status


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("Origin", "http://evil.example"),
        ("Origin", "null"),
        ("Origin", "https://{own}"),
        ("Origin", "http://127.0.0.1:1"),
        ("Origin", "http://{own}.evil.example"),
        ("Host", "evil.example:{port}"),  # its name was bound anew to 127.0.0.1
        ("Host", "127.0.0.1"),
        ("Host", ""),
    ],
)
def test_a_page_of_another_origin_is_refused(web: WebServer, name: str, value: str) -> None:
    own = urlsplit(web.url)
    reported = value.format(own=own.netloc, port=own.port)
    for path, good, headers in PARTS:
        assert answer(web, own.path + path, headers | {name: reported}) == 403
        assert answer(web, own.path + path, headers | {"Origin": f"http://{own.netloc}"}) == good
        assert answer(web, own.path + path, headers) == good  # a browser names no origin when it opens a page


def test_without_the_secret_nothing_is_answered(web: WebServer) -> None:
    secret = urlsplit(web.url).path.strip("/")
    assert len(secret) >= 32
    wrong = ("", "wrong/", f"{secret[:-1]}/", f"{secret}x/", f"{quote('é')}/", f"x/../{secret}/", "download/../")
    for path, good, headers in PARTS:
        assert {answer(web, f"/{each}{path}", headers) for each in wrong} <= {403, 404}
        assert answer(web, f"/{secret}/{path}", headers) == good


def test_each_server_has_a_secret_of_its_own(web: WebServer) -> None:
    with WebServer(["true"]) as other:
        assert answer(other, urlsplit(web.url).path, {}) == 403


def test_a_port_in_use_is_refused() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other, pytest.raises(PortTaken):
        serve(["true"], print, port=other.getsockname()[1])
