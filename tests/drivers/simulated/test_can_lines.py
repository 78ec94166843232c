"""A simulated slcan adapter, command by command, by the LAWICEL CAN232 manual; a bus over UDP multicast."""

import os
import select
import tty
from collections.abc import Iterator
from threading import Event, Thread

import pytest

from drivers.can.frame_record import EXTENDED, pack
from drivers.simulated.lines import MAX_WAITING_BYTES, SlcanAdapter, UdpMulticastLine
from tests.free_port import free_udp_port
from tests.patience import HANG_S, until


class Station:
    """Who opened the adapter's terminal."""

    def __init__(self, adapter: SlcanAdapter) -> None:
        self.far = os.open(adapter.address.removeprefix("can://slcan"), os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.far)

    def reported(self, size: int = 1) -> bytes:
        got = b""
        while len(got) < size:
            assert select.select([self.far], [], [], HANG_S)[0], f"only {got!r} came"
            got += os.read(self.far, size - len(got))
        return got

    def asked(self, command: bytes, size: int = 1) -> bytes:
        os.write(self.far, command + b"\r")
        return self.reported(size)


@pytest.fixture
def adapter() -> Iterator[SlcanAdapter]:
    line = SlcanAdapter()
    line.plug()
    yield line
    line.unplug()


@pytest.fixture
def station(adapter: SlcanAdapter) -> Iterator[Station]:
    one = Station(adapter)
    yield one
    os.close(one.far)


OK, ERROR = b"\r", b"\a"


def writable(adapter: SlcanAdapter) -> bool:
    """Say whether the adapter's terminal has room for more."""
    return bool(select.select([], [adapter._near], [], 0)[1])  # noqa: SLF001


@pytest.mark.parametrize(
    ("command", "closed", "opened"),
    [
        (b"", OK, OK), (b"V", b"V1013\r", b"V1013\r"), (b"N", b"NFOG1\r", b"NFOG1\r"),
        (b"S6", OK, ERROR), (b"S9", ERROR, ERROR), (b"s03E8", OK, ERROR), (b"s03E", ERROR, ERROR),
        (b"F", ERROR, b"F00\r"), (b"C", ERROR, OK), (b"Q", ERROR, ERROR),
        (b"t1230", ERROR, b"z\r"), (b"t12321122", ERROR, b"z\r"), (b"r7FF0", ERROR, b"z\r"),
        (b"T1FFFFFFF0", ERROR, b"Z\r"), (b"R000000010", ERROR, b"Z\r"),
        (b"t8000", ERROR, ERROR), (b"T200000000", ERROR, ERROR), (b"t1239", ERROR, ERROR), (b"t12", ERROR, ERROR),
    ],
)  # fmt: skip
def test_each_command_has_its_answer_on_a_closed_and_an_open_channel(
    station: Station, command: bytes, closed: bytes, opened: bytes
) -> None:
    assert station.asked(command, len(closed)) == closed
    assert station.asked(b"O") == OK
    assert station.asked(command, len(opened)) == opened


def test_a_bus_that_is_off_says_so_and_takes_no_frame(adapter: SlcanAdapter, station: Station) -> None:
    assert station.asked(b"O") == OK
    adapter.ails = "bus_off"
    assert station.asked(b"F", 4) == b"FA4\r"
    assert station.asked(b"t1230") == ERROR


def test_frames_go_to_whoever_opened_the_channel_and_wait_till_then(
    adapter: SlcanAdapter, station: Station
) -> None:
    sent = list[bool]()
    records = pack(0x123, 0, b"\x11\x22") + pack(EXTENDED | 0x1ABCDEF, 0, b"")
    writer = Thread(target=lambda: sent.append(adapter.write(records, Event())))
    writer.start()
    assert station.asked(b"O") == OK
    assert station.reported(21) == b"t12321122\rT01ABCDEF0\r"
    writer.join(HANG_S)
    assert sent == [True]


def test_what_waits_for_the_station_is_bounded_and_a_stop_ends_the_wait(
    adapter: SlcanAdapter, station: Station
) -> None:
    stop, sent = Event(), list[bool]()
    assert station.asked(b"O") == OK
    writer = Thread(target=lambda: sent.append(adapter.write(b"x" * 200_000, stop)))
    writer.start()
    until(lambda: len(adapter._out) >= MAX_WAITING_BYTES and not writable(adapter))  # noqa: SLF001  (all is full)
    assert not sent  # a terminal and what waits here hold a tenth of it
    assert len(adapter._out) < 2 * MAX_WAITING_BYTES  # noqa: SLF001
    stop.set()
    writer.join(HANG_S)
    assert sent == [False]


def test_frames_of_a_bus_over_multicast_come_to_another_and_noise_does_not() -> None:
    import can

    port = free_udp_port()
    line = UdpMulticastLine(port)
    assert line.write(pack(0x123, 0, b"\x01"), Event())  # nobody has joined: lost
    line.plug()
    with can.Bus(interface="udp_multicast", channel=line.address.rpartition("/")[2], port=port) as other:
        line.write(b"noise", Event())
        line.write(pack(0x123, 0, b"\x01\x02") + pack(EXTENDED | 0x1ABCDEF, 0, b"\x03"), Event())
        first, second = other.recv(HANG_S), other.recv(HANG_S)
        assert first is not None
        assert second is not None
        assert (first.arbitration_id, first.is_extended_id, bytes(first.data)) == (0x123, False, b"\x01\x02")
        assert (second.arbitration_id, second.is_extended_id, bytes(second.data)) == (0x1ABCDEF, True, b"\x03")
    stop = Event()
    stop.set()
    assert not line.write(b"", stop)
    line.unplug()
    line.unplug()
