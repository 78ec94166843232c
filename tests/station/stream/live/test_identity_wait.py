"""How long the station waits for a unit to say who it is: in the device's own time, live as in a replay."""

from pathlib import Path

from drivers.simulated.device import ByteDevice
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS, Identity
from station.files.mcap_files import StepWriter
from station.stream.live.live_feed import IDENTITY_S, open_feed
from station.stream.replay.imu import Replay

TRUTH = Truth(sample_period_s=0.02)
WIRE = FORMATS["counts"]


def recorded(path: Path, silent_s: float, lasts_s: float) -> str:
    """Write what a unit sent that says who it is only after ``silent_s``, and return its address."""
    device, writer = ByteDevice(TRUTH, 1, WIRE), StepWriter(path)
    assert WIRE.encode_identity is not None
    said = WIRE.encode_identity(Identity(TRUTH.model, TRUTH.serial, TRUTH.sample_period_s))
    while (now := device.imu.time) < lasts_s:
        parts = [part for part in device.chunk(5) if isinstance(part, bytes) and (now >= silent_s or part != said)]
        writer.write_raw(round(now * 1e9), b"".join(parts))
    writer.close()
    return f"replay:{path}"


def test_a_unit_that_is_late_to_say_who_it_is_is_waited_for(tmp_path: Path) -> None:
    feed = open_feed(Replay(recorded(tmp_path / "a.mcap", IDENTITY_S - 1.5, 20.0), speed=0.0))
    assert feed.identify("M", TRUTH.serial).model == TRUTH.model
    assert feed.buffer.end * TRUTH.sample_period_s < IDENTITY_S


def test_a_unit_that_never_says_it_is_waited_for_as_long_in_a_replay_at_full_speed(tmp_path: Path) -> None:
    feed = open_feed(Replay(recorded(tmp_path / "a.mcap", 30.0, 20.0), speed=0.0))
    assert feed.identify("M", "S-1").serial == "S-1"
    assert IDENTITY_S <= feed.buffer.end * TRUTH.sample_period_s < IDENTITY_S + 0.5


def test_a_replay_that_ends_before_is_the_unit_that_the_operator_names(tmp_path: Path) -> None:
    feed = open_feed(Replay(recorded(tmp_path / "a.mcap", 30.0, IDENTITY_S - 1.0), speed=0.0))
    assert feed.identify("M", "S-1").serial == "S-1"
