"""The lines themselves, without a device: who comes, who goes, what is sent whole and what is lost."""

import os
import select
import socket
import tty
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from threading import Event, Thread

import pytest

from drivers.simulated.lines import PtyLine, TcpLine, UdpLine
from tests.patience import HANG_S


@pytest.fixture
def tcp() -> Iterator[TcpLine]:
    line = TcpLine()
    line.plug()
    yield line
    line.unplug()


@pytest.fixture
def pty() -> Iterator[PtyLine]:
    line = PtyLine()
    line.plug()
    yield line
    line.unplug()


def port_of(address: str) -> tuple[str, int]:
    host, _, port = address.partition("://")[2].rpartition(":")
    return host, int(port)


def opened(line: PtyLine) -> int:
    far = os.open(line.address.removeprefix("serial://"), os.O_RDWR | os.O_NOCTTY)
    tty.setraw(far)
    return far


def read(descriptor: int) -> bytes:
    assert select.select([descriptor], [], [], HANG_S)[0]
    return os.read(descriptor, 65536)


def test_a_terminal_sends_whole_what_a_slow_reader_takes_bit_by_bit(pty: PtyLine) -> None:
    data, stop, far = os.urandom(60_000), Event(), opened(pty)
    sent = list[bool]()
    writer = Thread(target=lambda: sent.append(pty.write(data, stop)))
    writer.start()
    got = b""
    while len(got) < len(data):
        got += read(far)
    writer.join(HANG_S)
    os.close(far)
    assert got == data
    assert sent == [True]


def test_what_a_reader_sends_is_dropped_while_writing_and_handed_over_in_an_exchange(pty: PtyLine) -> None:
    far = opened(pty)
    os.write(far, b"dropped")
    assert pty.write(b"out", Event())
    assert read(far) == b"out"
    os.write(far, b"heard")
    assert pty.exchange(b"answer", HANG_S) == b"heard"
    assert read(far) == b"answer"
    assert pty.exchange(b"", 0.0) == b""
    os.close(far)


def test_a_link_points_at_the_terminal_of_the_day_and_goes_with_it(tmp_path: Path) -> None:
    link = tmp_path / "imu"
    line = PtyLine(link)
    line.plug()
    assert line.address == f"serial://{link}"
    assert link.is_symlink()
    far = os.open(link, os.O_RDWR | os.O_NOCTTY)
    line.unplug()
    assert not link.is_symlink()
    assert os.read(far, 10) == b""  # gone, not waiting
    os.close(far)
    line.unplug()  # a second time does nothing
    line.plug()
    assert os.path.exists(link.readlink())
    line.unplug()
    link.write_text("a file of somebody's")
    with pytest.raises(FileExistsError):
        line.plug()
    assert link.read_text() == "a file of somebody's"


def test_one_reader_at_a_time_and_the_next_when_it_has_left(tcp: TcpLine) -> None:
    with closing(socket.create_connection(port_of(tcp.address))) as first:
        assert tcp.write(b"one", Event())
        assert first.recv(10) == b"one"
        with closing(socket.create_connection(port_of(tcp.address))) as second:
            assert tcp.write(b"two", Event())
            assert first.recv(10) == b"two"
            first.close()
            while tcp.write(b"lost", Event()):  # until it is seen that the first has gone
                pass
            assert tcp.write(b"three", Event())
            assert second.recv(10) == b"three"


def test_a_bound_socket_answers_whoever_wrote_last() -> None:
    line = UdpLine()
    line.plug()
    there = port_of(line.address)
    assert line.address.startswith("udpout://127.0.0.1:")
    with socket.socket(type=socket.SOCK_DGRAM) as one, socket.socket(type=socket.SOCK_DGRAM) as two:
        for each in (one, two):
            each.bind(("127.0.0.1", 0))
            each.settimeout(HANG_S)
        assert line.exchange(b"to nobody", 0.0) == b""
        one.sendto(b"I", there)
        assert line.exchange(b"", HANG_S) == b"I"
        two.sendto(b"me", there)
        assert line.exchange(b"to one", HANG_S) == b"me"
        assert one.recv(10) == b"to one"
        assert line.exchange(b"to two", 0.0) == b""
        assert two.recv(10) == b"to two"
    line.unplug()
    line.unplug()
    with socket.socket(type=socket.SOCK_DGRAM) as taken:
        taken.bind(there)  # it has let go of its port
    line.plug()
    assert port_of(line.address) == there
    line.unplug()


EVERY = bytes(range(256))


def test_every_byte_goes_both_ways_as_it_is_whatever_the_reader_sets(pty: PtyLine) -> None:
    far = os.open(pty.address.removeprefix("serial://"), os.O_RDWR | os.O_NOCTTY)
    assert pty.write(EVERY, Event())
    got = b""
    while len(got) < len(EVERY):
        got += read(far)
    assert got == EVERY
    os.write(far, EVERY)
    got = b""
    while len(got) < len(EVERY):
        got += pty.exchange(b"", HANG_S)
    assert got == EVERY
    assert not select.select([far], [], [], 0.0)[0]  # no echo
    os.close(far)
