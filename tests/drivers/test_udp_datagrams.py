"""Single datagrams: sizes, who counts as a sender, and what each error of the machine means."""

import errno
import socket
from collections.abc import Iterator
from typing import Any

import pytest

from drivers.errors import LinkLost, PortDenied, PortNotFound
from drivers.udp_port import MAX_DATAGRAM_BYTES, RECEIVE_BUFFER_BYTES, UdpPort, open_udp
from tests.free_port import free_udp_port
from tests.patience import HANG_S


@pytest.fixture
def port() -> Iterator[UdpPort]:
    opened = open_udp("127.0.0.1", free_udp_port(), HANG_S, listens=True)
    yield opened
    opened.close()


def where(port: UdpPort) -> tuple[str, int]:
    host, _, number = port.name.rpartition(":")
    return host, int(number)


def sender() -> socket.socket:
    one = socket.socket(type=socket.SOCK_DGRAM)
    one.bind(("127.0.0.1", 0))
    one.settimeout(HANG_S)
    return one


def test_the_largest_datagram_comes_whole(port: UdpPort) -> None:
    largest = bytes(65507)
    assert len(largest) < MAX_DATAGRAM_BYTES
    with sender() as one:
        one.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, RECEIVE_BUFFER_BYTES)
        one.sendto(largest, where(port))
        assert port.read(1) == largest


def test_an_empty_datagram_makes_a_peer_and_hides_nothing_behind_it(port: UdpPort) -> None:
    with sender() as one:
        for part in (b"", b"data"):
            one.sendto(part, where(port))
        assert (port.read(100) or port.read(100)) == b"data"  # one that is empty may end a read
        port.write(b"answer")
        assert one.recv(10) == b"answer"
    assert port.peers == 1


def test_a_sender_that_sends_again_keeps_its_turn(port: UdpPort) -> None:
    some = [sender() for _ in range(3)]
    for each in (some[0], some[1], some[0], some[2], some[1]):
        each.sendto(b"x", where(port))
        assert port.read(1) == b"x"
    assert port.peers == 3
    port.write(b"to all")
    for each in some:
        assert each.recv(10) == b"to all"
        each.setblocking(False)
        with pytest.raises(BlockingIOError):  # once
            each.recv(10)
        each.close()


def test_a_port_has_room_for_a_burst(port: UdpPort) -> None:
    with sender() as one:
        for i in range(100):
            one.sendto(bytes([i]) * 1000, where(port))
        got = b""
        while len(got) < 100_000:
            got += port.read(100_000)
    assert got == b"".join(bytes([i]) * 1000 for i in range(100))


def test_a_port_that_calls_hears_nobody_there_and_goes_on() -> None:
    number = free_udp_port()
    calling = open_udp("127.0.0.1", number, 0.0, listens=False)
    calling._socket.connect(("127.0.0.1", number))  # noqa: SLF001  (so that the machine tells of the closed port)
    calling._socket.send(b"hello")  # noqa: SLF001
    assert calling.read(10) == b""
    assert calling.refused == 0
    calling.close()


class Refusing:
    """A socket that refuses with an error of a number."""

    def __init__(self, number: int) -> None:
        self.number, self.asked = number, 0

    def sendto(self, data: bytes, there: object) -> None:
        self.asked += 1
        raise OSError(self.number, "no")


def test_each_datagram_that_is_not_taken_is_counted() -> None:
    line: Any = Refusing(errno.ENETUNREACH)
    port = UdpPort(line, "x", 0.0, ("127.0.0.1", 9))
    for _ in range(3):
        port.write(b"lost")
    assert (port.refused, line.asked) == (3, 3)


def test_writing_to_a_port_that_was_closed_is_a_lost_link() -> None:
    calling = open_udp("127.0.0.1", free_udp_port(), 0.0, listens=False)
    calling.close()
    with pytest.raises(LinkLost, match="closed"):
        calling.write(b"hello")
    assert calling.refused == 0


@pytest.mark.parametrize(
    ("number", "refusal"),
    [(errno.EACCES, PortDenied), (errno.EPERM, PortDenied), (errno.EADDRNOTAVAIL, PortNotFound)],
)
def test_what_binding_refuses_is_said_and_the_socket_given_back(
    number: int, refusal: type[Exception], monkeypatch: pytest.MonkeyPatch
) -> None:
    closed = list[socket.socket]()

    class Bound(socket.socket):
        def bind(self, there: Any) -> None:
            raise OSError(number, "no")

        def close(self) -> None:
            closed.append(self)
            super().close()

    monkeypatch.setattr(socket, "socket", Bound)
    with pytest.raises(refusal):
        open_udp("127.0.0.1", 9, 0.0, listens=True)
    assert len(closed) == 1
