"""The lines themselves, without a device: who comes, who goes, what is sent whole and what is lost."""

import os
import select
import socket
import tty
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path
from threading import Event, Thread

import pytest

from drivers.simulated.serial_and_tcp_lines import PtyLine, TcpLine, UdpLine
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


def test_a_terminal_that_nobody_reads_is_stopped_and_says_so(pty: PtyLine) -> None:
    stop, ended = Event(), list[bool]()
    writer = Thread(target=lambda: ended.append(pty.write(bytes(100_000), stop)))
    writer.start()
    while not ended and select.select([], [pty._near], [], 0)[1]:  # noqa: SLF001  (until it is full)
        pass
    stop.set()
    writer.join(HANG_S)
    assert ended == [False]
    assert pty.write(b"", stop)


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
    with pytest.raises(FileExistsError, match="exists and is not a link"):
        line.plug()
    assert link.read_text() == "a file of somebody's"


def test_a_port_is_the_same_again_after_an_unplug(tcp: TcpLine) -> None:
    before = port_of(tcp.address)
    tcp.unplug()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(before)
    tcp.unplug()
    tcp.plug()
    assert port_of(tcp.address) == before
    socket.create_connection(before).close()


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


def test_a_reader_that_is_hung_up_on_reads_its_end(tcp: TcpLine) -> None:
    with closing(socket.create_connection(port_of(tcp.address))) as reader:
        assert tcp.write(b"a", Event())
        tcp.unplug()
        assert reader.recv(10) == b"a"
        assert reader.recv(10) == b""


def test_an_exchange_takes_a_caller_hears_it_and_lets_it_go(tcp: TcpLine) -> None:
    assert tcp.exchange(b"to nobody", 0.0) == b""
    with closing(socket.create_connection(port_of(tcp.address))) as caller:
        assert tcp.exchange(b"not to who calls only now", HANG_S) == b""
        caller.sendall(b"asked")
        assert tcp.exchange(b"answer", HANG_S) == b"asked"
        assert caller.recv(10) == b"answer"
        assert tcp.exchange(b"", 0.0) == b""
        caller.close()
        assert tcp.exchange(b"", HANG_S) == b""
    with closing(socket.create_connection(port_of(tcp.address))) as another:
        assert tcp.exchange(b"", HANG_S) == b""
        another.sendall(b"again")
        assert tcp.exchange(b"", HANG_S) == b"again"


def test_nobody_called_and_stopped(tcp: TcpLine) -> None:
    stop = Event()
    stop.set()
    assert not tcp.write(b"never", stop)
    assert tcp.write(b"", stop)


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


def test_a_socket_that_sends_to_somebody_goes_on_sending_there() -> None:
    with socket.socket(type=socket.SOCK_DGRAM) as station, socket.socket(type=socket.SOCK_DGRAM) as other:
        for each in (station, other):
            each.bind(("127.0.0.1", 0))
            each.settimeout(HANG_S)
        line = UdpLine(to=station.getsockname())
        line.plug()
        assert line.address == f"udpin://127.0.0.1:{station.getsockname()[1]}"
        assert line.exchange(b"first", 0.0) == b""
        said, there = station.recvfrom(10)
        assert said == b"first"
        other.sendto(b"who am I", there)
        assert line.exchange(b"", HANG_S) == b"who am I"
        assert line.exchange(b"second", 0.0) == b""
        assert station.recv(10) == b"second"
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


def test_an_answer_that_finds_no_room_is_lost_and_makes_nobody_wait(pty: PtyLine, tcp: TcpLine) -> None:
    for _ in range(40):
        assert pty.exchange(bytes(1000), 0.0) == b""
    far = opened(pty)
    got = len(read(far))
    while select.select([far], [], [], 0.0)[0]:
        got += len(os.read(far, 65536))
    assert 4000 < got < 40_000
    os.write(far, b"still here")
    assert pty.exchange(b"", HANG_S) == b"still here"
    os.close(far)
    with closing(socket.create_connection(port_of(tcp.address))) as caller:
        assert tcp.exchange(b"", HANG_S) == b""
        for _ in range(40):
            assert tcp.exchange(bytes(1_000_000), 0.0) == b""
        caller.sendall(b"still here")
        assert tcp.exchange(b"", HANG_S) == b"still here"


def test_a_link_is_named_by_its_whole_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    line = PtyLine(Path("imu"))
    (tmp_path / "imu").symlink_to("gone")  # of a device that was killed
    line.plug()
    assert line.address == f"serial://{tmp_path / 'imu'}"
    far = opened(line)
    assert line.write(b"here", Event())
    assert read(far) == b"here"
    os.close(far)
    line.unplug()


def test_a_reader_that_takes_nothing_holds_a_write_until_it_is_stopped(tcp: TcpLine) -> None:
    stop, ended, data = Event(), list[bool](), bytes(30_000_000)
    with closing(socket.create_connection(port_of(tcp.address))) as reader:
        writer = Thread(target=lambda: ended.append(tcp.write(data, stop)))
        writer.start()
        assert reader.recv(1)
        assert not ended  # no socket holds as much
        stop.set()
        writer.join(HANG_S)
        assert ended == [False]


def test_what_is_written_waits_for_the_first_reader_and_what_it_says_is_dropped(tcp: TcpLine) -> None:
    ended, data = list[bool](), os.urandom(1_000_000)
    writer = Thread(target=lambda: ended.append(tcp.write(data, Event())))
    writer.start()
    with closing(socket.create_connection(port_of(tcp.address))) as reader:
        reader.sendall(b"dropped")
        got = b""
        while len(got) < len(data):
            part = reader.recv(65536)
            assert part
            got += part
        writer.join(HANG_S)
        assert (ended, got == data) == ([True], True)
        reader.sendall(b"heard")
        assert tcp.exchange(b"", HANG_S).endswith(b"heard")


def test_a_line_listens_where_it_is_told_to() -> None:
    for _ in range(20):  # until nobody else has taken the port that was free
        first = TcpLine("127.0.0.1")
        first.plug()
        host, port = port_of(first.address)
        first.unplug()
        again = TcpLine(host, port)
        assert again.address == f"tcp://127.0.0.1:{port}"
        with suppress(OSError):
            again.plug()
            break
    assert port_of(again.address) == (host, port)
    again.unplug()


def test_nobody_there_is_no_error_of_a_socket_that_sends() -> None:
    with socket.socket(type=socket.SOCK_DGRAM) as gone:
        gone.bind(("127.0.0.1", 0))
        there = gone.getsockname()
    line = UdpLine(to=there)
    line.plug()
    for _ in range(3):
        assert line.exchange(b"anybody?", 0.0) == b""
    with socket.socket(type=socket.SOCK_DGRAM) as station:
        station.bind(there)
        station.settimeout(HANG_S)
        assert line.exchange(b"here", 0.0) == b""
        said, sender = station.recvfrom(65535)
        assert said == b"here"
        station.sendto(bytes(60_000), sender)
        assert len(line.exchange(b"", HANG_S)) == 60_000  # whole
        assert line.exchange(b"", 0.0) == b""
        station.setblocking(False)
        with pytest.raises(BlockingIOError):  # nothing is no datagram
            station.recv(10)
    line.unplug()
