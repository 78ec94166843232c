"""A recorded IMU as a source: all its chunks in order, at the pace that is asked for, and then an end."""

from pathlib import Path

import pytest

from drivers.errors import PortNotFound, ReplayEnded
from station.files.mcap_files import StepWriter
from station.stream.reader import Chunk
from station.stream.replay import imu
from station.stream.replay.imu import Replay
from tests.refusals import refused

CHUNKS = [(5_000_000_000, b"first"), (5_100_000_000, b"second"), (5_400_000_000, b"last")]


class Clock:
    """Time that passes only in `sleep`."""

    def __init__(self) -> None:
        self.now, self.slept = 100.0, list[float]()

    def monotonic(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.slept.append(seconds)
        self.now += seconds


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    monkeypatch.setattr(imu, "time", made)
    return made


@pytest.fixture
def url(tmp_path: Path) -> str:
    writer = StepWriter(tmp_path / "a.mcap")
    for host_ns, data in CHUNKS:
        writer.write_raw(host_ns, data)
    writer.close()
    return f"replay:{tmp_path / 'a.mcap'}"


def polled(replay: Replay, timeout_s: float) -> list[bytes]:
    return [each.data for each in replay.poll(timeout_s) if isinstance(each, Chunk)]


def test_at_full_speed_each_chunk_is_given_once_and_then_it_ends(url: str) -> None:
    replay = Replay(url, 0.0)
    given = [replay.poll(1.0) for _ in CHUNKS]
    assert given == [[Chunk(host_ns, data)] for host_ns, data in CHUNKS]
    with refused(ReplayEnded, None, "15"):  # bytes
        replay.poll(1.0)


@pytest.mark.parametrize("speed", [1.0, 2.0])
def test_at_a_pace_chunks_come_when_they_are_due(url: str, clock: Clock, speed: float) -> None:
    replay = Replay(url, speed)
    assert polled(replay, 1.0) == [b"first"]
    assert clock.slept == []
    assert polled(replay, 0.04) == []
    assert polled(replay, 1.0) == [b"second"]
    assert sum(clock.slept) == pytest.approx(0.1 / speed)
    clock.now += 10.0
    assert polled(replay, 0.0) == [b"last"]


def test_a_file_without_bytes_of_a_device_is_no_source(tmp_path: Path) -> None:
    StepWriter(tmp_path / "a.mcap").close()
    with pytest.raises(PortNotFound):
        Replay(f"replay:{tmp_path / 'a.mcap'}")
