"""The reader process over real ptys: nothing lost, gaps marked, refusals as they are; its queue never waits."""

import os
import signal
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from mcap.reader import make_reader

from drivers import errors
from drivers.address_parsing import parse_device_url
from drivers.errors import DriverError, LinkLost, PortNotFound, ReplayEnded
from drivers.framing import Decoder
from drivers.simulated.bench_control import BenchControl
from drivers.simulated.faults import Fault
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from procedures.errors import ErrorCode
from station.errors import CannotWrite
from station.files.mcap_files import read_step
from station.stream.reader import Chunk, Reader, StreamGap
from station.stream.reader import __main__ as process
from station.stream.reader.messages import Outbox, Refusal, packed, unpacked
from tests.patience import HANG_S, paced
from tests.refusals import refused

RECENT_S = 3600.0


def collect(reader: Reader, frames: int) -> list[Chunk | StreamGap]:
    """Read until a decoder has had that many frames."""
    decoder, items, deadline = Decoder(FORMATS["counts"]), list[Chunk | StreamGap](), time.monotonic() + HANG_S
    while decoder.counters.frames < frames:
        assert time.monotonic() < deadline, decoder.counters
        for item in reader.poll(1.0):
            items.append(item)
            if isinstance(item, Chunk):
                decoder.feed(item.data)
    return items


def rest_of(reader: Reader) -> list[Chunk | StreamGap]:
    """Read until a replay is at its end."""
    items = list[Chunk | StreamGap]()
    with suppress(ReplayEnded):
        while True:
            items += reader.poll(1.0)
    return items


def data_of(items: list[Chunk | StreamGap]) -> bytes:
    return b"".join(item.data for item in items if isinstance(item, Chunk))


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "recording.mcap"


@pytest.fixture
def line() -> Iterator[tuple[int, str]]:
    """A pty: its far end and the URL of its near one."""
    far, near = os.openpty()
    yield far, f"serial://{os.ttyname(near)}?format=counts"
    os.close(far)
    os.close(near)


def test_the_station_and_the_recording_get_the_same_bytes(file: Path) -> None:
    with SimulatedDevice(Truth.example(1), 1, speed=paced(50.0)) as device, Reader(device.url, file) as reader:
        items = collect(reader, 500)
    recorded = read_step(file)
    assert recorded.damage is None
    got = data_of(items)
    assert b"".join(data for _, data in recorded.raw)[: len(got)] == got
    stamps = [item.host_ns for item in items]
    assert stamps == sorted(stamps)
    assert abs(stamps[0] - time.time_ns()) < RECENT_S * 1e9  # counted from the epoch


def test_an_unplugged_port_is_opened_again_and_the_gap_is_marked_twice(file: Path, tmp_path: Path) -> None:
    faults = [Fault("unplug", at_s=2.0, seconds=1.0), Fault("unplug", at_s=6.0, seconds=1.0)]
    link = tmp_path / "imu"
    with SimulatedDevice(Truth.example(1), 1, speed=paced(5.0), faults=faults, link=link, hold=True) as device:
        with Reader(device.url, file) as reader, BenchControl(device.control) as hands:
            hands.go()
            items = collect(reader, 350)
        marks = [item for item in items if isinstance(item, StreamGap)]
    assert [mark.is_open for mark in marks] == [False, True, False, True]
    assert "lost" in marks[0].reason
    assert "back after" in marks[1].reason
    with file.open("rb") as stream:
        records = [m for m in make_reader(stream).iter_metadata() if m.name == "station.gap"]
    assert [int(m.metadata["host_ns"]) for m in records] == [mark.host_ns for mark in marks]


def test_the_recording_survives_the_death_of_its_process(file: Path) -> None:
    with SimulatedDevice(Truth.example(1), 1, speed=paced(50.0)) as device, Reader(device.url, file) as reader:
        items, empty = list[Chunk | StreamGap](), file.stat().st_size
        while file.stat().st_size == empty:  # until the first flush
            items += reader.poll(1.0)
        os.kill(reader.pid, signal.SIGKILL)
        with pytest.raises(LinkLost):
            rest_of(reader)
    recorded = read_step(file)
    assert recorded.damage is not None
    kept = b"".join(data for _, data in recorded.raw)
    assert 0 < len(kept)
    assert data_of(items).startswith(kept[: len(data_of(items))])


def test_a_replay_ends_after_all_of_its_bytes(file: Path, tmp_path: Path) -> None:
    content = FORMATS["counts"].example * 5000
    (tmp_path / "raw.bin").write_bytes(content)
    with Reader(f"replay:{tmp_path / 'raw.bin'}?format=counts", file) as reader:
        assert data_of(rest_of(reader)) == content
        with pytest.raises(ReplayEnded):
            reader.poll(1.0)


def test_a_missing_port_is_reported_as_it_is(file: Path) -> None:
    with refused(PortNotFound, ErrorCode.DEVICE, port="/dev/ttyNONE"), Reader("serial:///dev/ttyNONE", file):
        pass
    assert not file.exists()


def test_a_recording_is_never_overwritten(file: Path, line: tuple[int, str]) -> None:
    file.write_text("here before")
    with pytest.raises(CannotWrite), Reader(line[1], file):
        pass
    assert file.read_text() == "here before"


@pytest.mark.parametrize(
    "error",
    [
        errors.PortNotFound("/dev/x", "no such port", "look"),
        errors.LinkSilent("/dev/x", 2.0, 9600),
        errors.WrongFormat("/dev/x", "counts", 10),
    ],
    ids=lambda error: type(error).__name__,
)
def test_an_error_passes_the_pipe_unchanged(error: DriverError) -> None:
    [received] = unpacked(bytearray(packed(Refusal(type(error), str(error), vars(error)))))
    assert isinstance(received, Refusal)
    again = received.error
    assert type(again) is type(error)
    assert (str(again), vars(again)) == (str(error), vars(error))


def test_a_station_that_does_not_read_makes_nobody_wait() -> None:
    reading, writing = os.pipe()
    outbox = Outbox(writing, limit=1_000_000)
    taken = 0
    while outbox.put(b"x" * 1000):  # many times what a pipe holds
        taken += 1
    assert 900 < taken < 1200
    assert outbox.put(b"y", always=True)
    got = 0
    while got < taken * 1000 + 1:
        got += len(os.read(reading, 65536))
    outbox.wait_for_room(60.0)
    assert outbox.put(b"z")
    outbox.close(60.0)
    assert os.read(reading, 10) == b"z"


def test_messages_arrive_whole_and_in_order_however_large(monkeypatch: pytest.MonkeyPatch) -> None:
    reading, writing = os.pipe()
    sizes, real = list[int](), os.write

    def write(descriptor: int, data: memoryview) -> int:
        if descriptor != writing:
            return real(descriptor, data)
        sizes.append(len(data))
        return real(descriptor, data[: max(1, len(data) // 2)])  # as a pipe that is nearly full

    monkeypatch.setattr(os, "write", write)
    outbox = Outbox(writing)
    reported = [bytes([i]) * size for i, size in enumerate((1, 0, 200_000, 3, 70_000))]
    for message in reported:
        assert outbox.put(message)
    got = b""
    while len(got) < sum(map(len, reported)):
        got += os.read(reading, 65536)
    outbox.close(HANG_S)
    assert got == b"".join(reported)
    assert max(sizes) <= 65536


class Crowded:
    """An outbox that has room, or has none, as it was set up; what it takes is kept."""

    def __init__(self, *has_room: bool) -> None:
        self.has_room, self.taken = list(has_room), bytearray()

    def put(self, message: bytes, *, always: bool = False) -> bool:
        has_room = self.has_room.pop(0)
        self.taken += message if has_room else b""
        return has_room


def test_each_byte_that_was_not_collected_is_reported_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(process, "ReconnectingPort", lambda *given: None)
    outbox = Crowded(False, False, True, False, True, True, True)
    url = parse_device_url("serial:///dev/ttyUSB0?format=counts")
    session = process._Session(url, None, outbox)  # noqa: SLF001
    for host_ns, size in enumerate((3, 5, 7, 11, 13)):
        session._hand_on(Chunk(host_ns, b"x" * size))  # noqa: SLF001
    assert outbox.has_room == []
    assert list(unpacked(outbox.taken)) == [
        StreamGap(2, "8 bytes not collected in time; they are lost", is_open=True),
        StreamGap(3, "7 bytes not collected in time; they are lost", is_open=True),
        Chunk(3, b"x" * 11),
        Chunk(4, b"x" * 13),
    ]
