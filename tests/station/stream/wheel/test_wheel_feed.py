"""A wheel's frames as they come: readings, what is wrong and when, and the same again of a recording."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from drivers.can.frame_record import WheelReading, pack
from drivers.simulated.companions.wheel_on_can import DBC, wheel_toml
from station.files.mcap_files.schemas import RAW_TOPIC, WHEEL_RAW_TOPIC
from station.stream.reader import Chunk, StreamGap
from station.stream.reader.raw_recording import RawRecording
from station.stream.wheel import WheelDescription, WheelFeed, read_description, recorded_wheel

NS = 10**9
BUS = "can://slcan/dev/ttyNONE?bitrate=500000"
UNKNOWN = pack(288, 0, b"\xff" * 8)  # the signal says that it does not know
OTHERS = pack(0x7FF, 0, b"\x01" * 8)
GONE, BACK = StreamGap(0, "port lost: gone", False), StreamGap(0, "port back", True)


@pytest.fixture(scope="module")
def described(tmp_path_factory: pytest.TempPathFactory) -> WheelDescription:
    file = tmp_path_factory.mktemp("wheel") / "axle.toml"
    file.write_text(wheel_toml(BUS, DBC))
    return read_description(file)


class Bus:
    """Frames of a bus at moments that are set, and the feed that hears them."""

    def __init__(self, described: WheelDescription) -> None:
        self.now, self.up_to_ns, self.address = 0.0, 0, described.address
        self._items, self._signal = list[Chunk | StreamGap](), described.signal
        source: Any = self
        self.feed = WheelFeed(source, described, lambda: self.now)

    def poll(self, timeout_s: float) -> list[Chunk | StreamGap]:
        items, self._items = self._items, []
        return items

    def hear(self, at: float, *reported: float | bytes | StreamGap) -> str:
        """Return what is wrong after speeds [m/s], other frames and marks came at a time."""
        self.now, host_ns = at, round(at * NS)
        for each in reported:
            data = self._signal.frame(each, host_ns) if isinstance(each, float) else each
            self._items.append(each if isinstance(each, StreamGap) else Chunk(host_ns, bytes(data)))  # type: ignore[arg-type]
        self.feed.advance()
        return self.feed.trouble


@pytest.fixture
def bus(described: WheelDescription) -> Bus:
    return Bus(described)


def test_each_speed_is_a_reading_of_the_moment_it_came(bus: Bus) -> None:
    bus.hear(1.0, 10.0, UNKNOWN, OTHERS)
    bus.hear(1.5, 12.5)
    (first,), (second,) = bus.feed.take(NS), bus.feed.take(2 * NS)
    assert (first.host_ns, second.host_ns) == (NS, 3 * NS // 2)
    assert [first.speed, second.speed] == pytest.approx([10.0, 12.5], abs=0.002)
    assert bus.feed.readings == 2


def test_its_health_and_its_summary_count_speeds_and_what_is_none(bus: Bus) -> None:
    for i in range(10):
        assert bus.hear(0.5 * i, 1.0) == ""
    bus.hear(4.5, UNKNOWN, OTHERS)
    bus.hear(5.0, b"\x00" * 24)
    state = bus.feed.stream()
    assert state.name == f"wheel {bus.feed.address.name}"
    assert (state.samples, state.gaps, state.lost, state.trouble) == (10, 0, 1, "")
    assert state.bad == bus.feed.decoder.bad
    assert [state.rate_hz, state.age_s] == pytest.approx([10 / 5, 0.5])
    assert bus.feed.summary == (
        f"wheel {bus.feed.address.name}: 10 speeds by WHEELS.SPEED, 1 without a value, {state.bad} damaged"
    )
    bus.hear(5.1)
    assert bus.feed.stream().rate_hz == pytest.approx(9 / 5)  # the first one is of more than five seconds ago
    bus.hear(9.5)
    assert bus.feed.stream().rate_hz == pytest.approx(1 / 5)


def test_frames_that_give_no_speed_are_reported_after_so_long(bus: Bus) -> None:
    assert bus.hear(1.0, 5.0) == ""
    assert bus.hear(2.75, OTHERS, UNKNOWN) == ""
    assert bus.hear(2.85, OTHERS) == (
        f"{bus.feed.address.name}: frames contain no WHEELS.SPEED, expected a speed; "
        "check dbc and signal, or its sensor"
    )
    assert bus.feed.stream().trouble == bus.feed.trouble
    assert bus.feed.stream().age_s == pytest.approx(1.85)
    assert bus.hear(2.9, 0.0) == ""


def test_a_port_that_went_is_reported_and_once_back_it_has_as_long_for_a_speed(bus: Bus) -> None:
    assert "port lost: gone; it is tried again and again" in bus.hear(1.0, GONE)
    assert "port lost" in bus.hear(9.0)
    assert bus.hear(10.0, BACK) == ""
    assert bus.hear(11.75, OTHERS) == ""
    assert "contain no WHEELS.SPEED" in bus.hear(11.85, OTHERS)


def record(folder: Path, number: int, chunks: list[Chunk], topic: str = WHEEL_RAW_TOPIC) -> None:
    failures = list[Exception]()
    recording = RawRecording(folder / f"wheel_session_{number}.mcap", {}, failures.append, topic)
    for chunk in chunks:
        recording.put(chunk)
    recording.close()
    assert not failures


def test_a_recording_gives_the_readings_of_all_its_sessions_in_order(
    described: WheelDescription, tmp_path: Path
) -> None:
    def frame(speed: float) -> bytes:
        return described.signal.frame(speed, 0)

    record(tmp_path, 2, [Chunk(5 * NS, frame(3.0))])
    record(tmp_path, 1, [Chunk(NS, frame(1.0)), Chunk(2 * NS, frame(2.0) + frame(2.5)[:9])])
    record(tmp_path, 3, [Chunk(9 * NS, frame(9.0))], RAW_TOPIC)  # of another device
    found = list(recorded_wheel(tmp_path, described))
    assert [each.host_ns for each in found] == [NS, 2 * NS, 5 * NS]
    assert [each.speed for each in found] == pytest.approx([1.0, 2.0, 3.0], abs=0.002)
    assert found[0] == replace(found[0], read_ns=7)
    assert isinstance(found[0], WheelReading)
