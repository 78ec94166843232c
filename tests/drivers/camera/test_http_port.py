"""A stream over HTTP is asked for and read; whoever answers something else is told what was expected."""

import socket
from base64 import b64encode
from collections.abc import Iterator
from contextlib import closing
from threading import Thread

import pytest

from drivers.camera import CameraDecoder, http_port
from drivers.camera.decoder import CONTENT_TYPE, part
from drivers.errors import LinkLost, PortNotFound
from drivers.port_interface import Port
from drivers.ports import open_port
from procedures.errors import ErrorCode
from tests.drivers.camera.images import jpegs
from tests.patience import HANG_S
from tests.refusals import refused

OK = f"HTTP/1.1 200 OK\r\ncontent-type: {CONTENT_TYPE}\r\n\r\n".encode()


class Server:
    """Answers one call with set bytes, and hangs up when told."""

    def __init__(self) -> None:
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"camera:http://127.0.0.1:{self.listener.getsockname()[1]}/stream?q=1"
        self.caller: socket.socket | None = None
        self.asked = b""

    def answer(self, data: bytes, *, hang_up: bool = False) -> None:
        def run() -> None:
            self.caller, _ = self.listener.accept()
            while b"\r\n\r\n" not in self.asked:
                self.asked += self.caller.recv(4096)
            self.caller.sendall(data)
            if hang_up:
                self.caller.close()

        self.thread = Thread(target=run)
        self.thread.start()

    def close(self) -> None:
        self.thread.join()
        self.listener.close()
        if self.caller is not None:
            self.caller.close()


@pytest.fixture
def server() -> Iterator[Server]:
    with closing(Server()) as server:
        yield server


def read_all(port: Port, size: int) -> bytes:
    data = b""
    while len(data) < size:
        piece = port.read(1000)
        assert piece
        data += piece
    return data


def test_a_stream_is_asked_for_and_read(server: Server) -> None:
    stream = b"".join(part(jpeg) for jpeg in jpegs())
    server.answer(OK + stream)
    with closing(open_port(server.url, timeout_s=HANG_S)) as port:
        got = read_all(port, len(stream))
    assert got == stream
    assert len(CameraDecoder().feed(got, 0)) == 4
    assert server.asked.startswith(b"GET /stream?q=1 HTTP/1.0\r\nHost: 127.0.0.1:")
    assert b"Authorization" not in server.asked


def test_silence_is_nothing_and_long_silence_a_loss(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    server.answer(OK)
    with closing(open_port(server.url, timeout_s=0.01)) as port:
        assert port.read(100) == b""
        monkeypatch.setattr(http_port, "SILENT_S", 0.0)
        with pytest.raises(LinkLost):
            port.read(100)


def test_a_camera_that_hangs_up_is_lost(server: Server) -> None:
    server.answer(OK + b"abc", hang_up=True)
    with closing(open_port(server.url, timeout_s=HANG_S)) as port:
        assert read_all(port, 3) == b"abc"
        with pytest.raises(LinkLost):
            port.read(100)


def test_who_asks_is_answered_as_basic(server: Server) -> None:
    server.answer(OK)
    open_port(server.url.replace("http://", "http://me:p%40ss@")).close()
    assert b"Authorization: Basic " + b64encode(b"me:p@ss") in server.asked


@pytest.mark.parametrize(
    ("answer", "reported"),
    [
        (b"HTTP/1.0 404 Not Found\r\n\r\n", "404 Not Found"),
        (b"HTTP/1.1 302 Found\r\nLocation: https://cam/\r\n\r\n", "https://cam/"),
        (b"HTTP/1.1 401 Unauthorized\r\n\r\n", "USER:PASSWORD@"),
        (b"HTTP/1.0 200 OK\r\nContent-Type: text/html\r\n\r\n", "text/html"),
        (b"HTTP/1.0 200 OK\r\n\r\n", ""),
        (OK.replace(b"\r\n\r\n", b"\r\nTransfer-Encoding: chunked\r\n\r\n"), "chunked"),
        (b"SSH-2.0-OpenSSH_9.6\r\n\r\n", "SSH-2.0-OpenSSH_9.6"),
        (bytes(70000), "70000"),
    ],
)
def test_another_answer_is_refused_in_one_line(server: Server, answer: bytes, reported: str) -> None:
    server.answer(answer)
    with refused(PortNotFound, ErrorCode.DEVICE, reported) as caught:
        open_port(server.url)
    assert "\n" not in str(caught.value)


def test_no_answer_is_waited_for_not_for_ever(server: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(http_port, "ANSWER_S", 0.05)
    server.answer(b"")
    with pytest.raises(PortNotFound):
        open_port(server.url)
