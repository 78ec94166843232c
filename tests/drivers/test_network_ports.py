"""A UDP port: who is heard and answered, sizes of datagrams, what is counted as not sent."""

import errno
import socket
from collections.abc import Iterator
from typing import Any

import pytest

from drivers.errors import LinkLost, PortBusy, PortNotFound
from drivers.network_ports import MAX_DATAGRAM_BYTES, MAX_PEERS, RECEIVE_BUFFER_BYTES, UdpPort, open_udp
from tests.free_port import free_udp_port
from tests.patience import HANG_S


@pytest.fixture
def port() -> Iterator[UdpPort]:
    opened = open_udp("127.0.0.1", free_udp_port(), HANG_S, listens=True)
    yield opened
    opened.close()


def address(port: UdpPort) -> tuple[str, int]:
    host, _, number = port.name.rpartition(":")
    return host, int(number)


@pytest.fixture
def other() -> Iterator[socket.socket]:
    with socket.socket(type=socket.SOCK_DGRAM) as one:
        one.bind(("127.0.0.1", 0))
        one.settimeout(HANG_S)
        yield one


def test_datagrams_are_read_end_to_end_and_whoever_sent_them_is_answered(
    port: UdpPort, other: socket.socket
) -> None:
    assert port.peers == 0
    port.write(b"to nobody")
    for part in (b"one", b"two"):
        other.sendto(part, address(port))
    got = port.read(1000)
    assert got + (b"" if got == b"onetwo" else port.read(1000)) == b"onetwo"
    assert port.peers == 1
    port.write(b"answer")
    assert other.recv(20) == b"answer"
    assert port.refused == 0


def test_all_senders_are_answered_up_to_a_number(port: UdpPort) -> None:
    some = [socket.socket(type=socket.SOCK_DGRAM) for _ in range(MAX_PEERS + 1)]
    for each in some:
        each.bind(("127.0.0.1", 0))
        each.settimeout(HANG_S)
        each.sendto(b"here", address(port))
        assert port.read(4) == b"here"
    assert port.peers == MAX_PEERS
    port.write(b"hello")
    assert [each.recv(10) for each in some[1:]] == [b"hello"] * MAX_PEERS
    some[0].setblocking(False)
    with pytest.raises(BlockingIOError):  # the first has given way to the last
        some[0].recv(10)
    for each in some:
        each.close()


def test_a_port_that_calls_writes_to_its_peer_alone(other: socket.socket) -> None:
    calling = open_udp(*other.getsockname(), 0.0, listens=False)
    assert calling.peers == 1
    calling.write(b"hello")
    reported, there = other.recvfrom(10)
    assert reported == b"hello"
    other.sendto(b"back", there)
    while not (got := calling.read(10)):
        pass
    assert got == b"back"
    assert calling.read(10) == b""  # after its timeout
    calling.close()
    with pytest.raises(LinkLost):
        calling.read(10)


def test_what_the_machine_does_not_send_is_counted_and_a_peer_that_is_not_there_is_not() -> None:
    class Deaf:
        def __init__(self, number: int) -> None:
            self.number = number

        def sendto(self, data: bytes, where: object) -> None:
            raise OSError(self.number, "no")

    for number, refused in ((errno.ENOBUFS, 1), (errno.ECONNREFUSED, 0)):
        line: Any = Deaf(number)
        port = UdpPort(line, "x", 0.0, ("127.0.0.1", 9))
        port.write(b"lost")
        assert port.refused == refused


def test_an_address_that_is_taken_or_none_is_refused(port: UdpPort) -> None:
    with pytest.raises(PortBusy):
        open_udp(*address(port), 0.0, listens=True)
    with pytest.raises(PortNotFound, match=r"no\.such\.host\.invalid"):
        open_udp("no.such.host.invalid", 5, 0.0, listens=True)
    with pytest.raises(PortNotFound, match=r"192\.0\.2\.1"):
        open_udp("192.0.2.1", 0, 0.0, listens=True)


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
        one.sendto(largest, address(port))
        assert port.read(1) == largest


def test_an_empty_datagram_makes_a_peer_and_hides_nothing_behind_it(port: UdpPort) -> None:
    with sender() as one:
        for part in (b"", b"data"):
            one.sendto(part, address(port))
        assert (port.read(100) or port.read(100)) == b"data"  # one that is empty may end a read
        port.write(b"answer")
        assert one.recv(10) == b"answer"
    assert port.peers == 1
