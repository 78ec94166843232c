"""A simulated slcan adapter, command by command, by the LAWICEL CAN232 manual; a bus over UDP multicast."""

import os
import select
import tty
from collections.abc import Iterator
from pathlib import Path
from threading import Event, Thread

import pytest

from drivers.can.frame_record import EXTENDED, pack
from drivers.simulated.can_lines import MAX_WAITING_BYTES, SlcanAdapter, UdpMulticastLine
from tests.free_port import free_udp_port
from tests.patience import HANG_S, until


class Station:
    """Who opened the adapter's terminal."""

    def __init__(self, adapter: SlcanAdapter) -> None:
        self.far = os.open(adapter.address.removeprefix("can://slcan"), os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.far)

    def said(self, size: int = 1) -> bytes:
        got = b""
        while len(got) < size:
            assert select.select([self.far], [], [], HANG_S)[0], f"only {got!r} came"
            got += os.read(self.far, size - len(got))
        return got

    def asked(self, command: bytes, size: int = 1) -> bytes:
        os.write(self.far, command + b"\r")
        return self.said(size)


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


def test_a_channel_is_opened_once_and_listens_only_as_well(station: Station) -> None:
    assert [station.asked(each) for each in (b"O", b"O", b"L", b"C", b"C", b"L", b"O")] == [
        OK, ERROR, ERROR, OK, ERROR, OK, ERROR,
    ]  # fmt: skip


def test_a_command_that_comes_in_pieces_and_two_in_one(station: Station) -> None:
    os.write(station.far, b"V\rN")
    assert station.said(6) == b"V1013\r"
    os.write(station.far, b"\r")
    assert station.said(6) == b"NFOG1\r"


def test_a_bus_that_is_off_says_so_and_takes_no_frame(adapter: SlcanAdapter, station: Station) -> None:
    assert station.asked(b"O") == OK
    adapter.ails = "bus_off"
    assert station.asked(b"F", 4) == b"FA4\r"
    assert station.asked(b"t1230") == ERROR


def test_an_adapter_that_hangs_answers_nothing_and_later_what_comes_then(
    adapter: SlcanAdapter, station: Station
) -> None:
    adapter.ails = "adapter_hangs"
    os.write(station.far, b"V\r")
    until(lambda: not select.select([adapter._near], [], [], 0)[0])  # noqa: SLF001  (it has read the command)
    with adapter._room:  # noqa: SLF001  (and is done with it)
        adapter.ails = ""
    assert station.asked(b"N", 6) == b"NFOG1\r"


def test_frames_go_to_whoever_opened_the_channel_and_wait_till_then(
    adapter: SlcanAdapter, station: Station
) -> None:
    sent = list[bool]()
    records = pack(0x123, 0, b"\x11\x22") + pack(EXTENDED | 0x1ABCDEF, 0, b"")
    writer = Thread(target=lambda: sent.append(adapter.write(records, Event())))
    writer.start()
    assert station.asked(b"O") == OK
    assert station.said(21) == b"t12321122\rT01ABCDEF0\r"
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


def test_an_adapter_that_is_taken_away_ends_a_write_and_comes_back_closed(adapter: SlcanAdapter) -> None:
    sent = list[bool]()
    writer = Thread(target=lambda: sent.append(adapter.write(b"t1230\r", Event())))
    writer.start()
    adapter.unplug()
    writer.join(HANG_S)
    assert sent == [False]
    adapter.plug()
    station = Station(adapter)
    assert station.asked(b"F") == ERROR  # closed, whatever it was before
    os.close(station.far)


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


def test_noise_and_broken_records_go_over_the_line_as_they_are(adapter: SlcanAdapter, station: Station) -> None:
    assert station.asked(b"O") == OK
    record = pack(0x123, 0, b"\x11")
    for data in (b"no record", record + b"?", record[:-1]):
        assert adapter.write(data, Event())
        assert station.said(len(data)) == data
    assert adapter.write(b"", Event())


def test_more_than_may_wait_goes_whole_and_in_order_to_who_reads(adapter: SlcanAdapter, station: Station) -> None:
    sent, data = list[bool](), os.urandom(5 * MAX_WAITING_BYTES + 7)
    assert station.asked(b"O") == OK
    writer = Thread(target=lambda: sent.append(adapter.write(data, Event())))
    writer.start()
    assert station.said(len(data)) == data
    writer.join(HANG_S)
    assert sent == [True]


def test_a_channel_that_is_closed_holds_what_is_written_until_it_is_open_again(
    adapter: SlcanAdapter, station: Station
) -> None:
    assert [station.asked(b"O"), station.asked(b"C")] == [OK, OK]
    sent = list[bool]()
    writer = Thread(target=lambda: sent.append(adapter.write(b"t1230\r", Event())))
    writer.start()
    assert station.asked(b"N", 6) == b"NFOG1\r"  # nothing came in between
    assert not sent
    os.write(station.far, b"L\r")
    assert station.said(7) == b"\rt1230\r"
    writer.join(HANG_S)
    assert sent == [True]


def test_what_waited_when_the_adapter_was_taken_away_does_not_come_later() -> None:
    adapter = SlcanAdapter()
    adapter.plug()
    station = Station(adapter)
    assert station.asked(b"O") == OK
    assert adapter.write(b"x" * MAX_WAITING_BYTES, Event())
    adapter.unplug()
    os.close(station.far)
    adapter.plug()
    station = Station(adapter)
    assert station.asked(b"V", 6) == b"V1013\r"
    os.close(station.far)
    adapter.unplug()


def test_its_address_says_what_it_is(tmp_path: Path) -> None:
    adapter = SlcanAdapter(tmp_path / "serial:")
    assert adapter.address == f"can://slcan{tmp_path}/serial:"
    assert UdpMulticastLine().address == "can://udp_multicast/239.74.163.2"


@pytest.mark.parametrize(
    ("command", "answer"),
    [
        (b"t7FF81122334455667788", b"z\r"), (b"t80000", ERROR), (b"R1FFFFFFF8", b"Z\r"), (b"T1ABCDEF11FF", b"Z\r"),
        (b"t1230g", ERROR), (b"t12301", ERROR), (b"T123", ERROR), (b"O1", ERROR), (b"s", ERROR),
    ],
)  # fmt: skip
def test_frames_are_taken_by_their_form(station: Station, command: bytes, answer: bytes) -> None:
    assert station.asked(b"O") == OK
    assert station.asked(command, len(answer)) == answer
