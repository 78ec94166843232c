"""Whether a device was switched off and on, and how long the station waits for it to say who it is."""

from pathlib import Path

import pytest

from drivers.simulated.device import ByteDevice
from drivers.simulated.faults import Fault
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS, Identity
from station.files.mcap_files import StepWriter
from station.stream.live.live_feed import IDENTITY_S, open_feed
from station.stream.live.stream_trouble import switched_on_again, switched_on_again_within
from station.stream.replay import Replay
from tests.station.stream.live.bench_in_memory import Source


@pytest.mark.parametrize(
    ("before", "now", "elapsed", "expected"),
    [
        (1000.0, 3.0, 10.0, True),  # began again
        (1000.0, 1030.0, 30.0, False),  # the port alone was away
        (1000.0, 1000.5, 600.0, False),  # a simulated device that nobody read
        (1000.0, 7200.0, 86400.0, True),  # switched on two hours ago, the next day
        (1000.0, 1600.0, 10.0, False),  # a simulated device that runs faster
    ],
)
def test_a_clock_that_does_not_turn(before: float, now: float, elapsed: float, *, expected: bool) -> None:
    assert switched_on_again(before, now, elapsed) is expected


@pytest.mark.parametrize(
    ("before", "now", "elapsed", "turn", "expected"),
    [
        (4290.0, 5.0, 10.0, 4294.967, False),  # it turned
        (2000.0, 3.0, 10.0, 4294.967, True),
        (2000.0, 2010.0, 10.0, 4294.967, False),
        (0.5, 0.1, 10.0, 1.0, False),  # it turns too soon to tell
        (2000.0, 3000.0, 10.0, 4294.967, False),  # strange, and no beginning
    ],
)
def test_a_clock_that_turns(before: float, now: float, elapsed: float, turn: float, *, expected: bool) -> None:
    assert switched_on_again_within(before, now, elapsed, turn) is expected


@pytest.mark.parametrize("format", ["counts", "rawimux", "stim300"])  # the last one's clock turns too soon to tell
@pytest.mark.parametrize(
    ("kind", "restarts"),
    [("restart", 1), ("unplug", 0), ("counter_restart", 0), ("clock_jump", 0)],
)
def test_a_restart_is_distinguished_from_all_else_that_interrupts_a_stream(
    format: str, kind: str, restarts: int
) -> None:
    truth = Truth.example(1)
    feed = open_feed(Source(truth, [Fault(kind, at_s=30.0, seconds=8.0, count=20)], format))
    if format == "counts":
        feed.identify()
    else:
        feed.identify("FOG", "1")
    blocks = feed.blocks()
    while next(blocks).first < 50 / truth.sample_period_s - 600:
        feed.buffer.forget_before(feed.buffer.end)
    assert feed.restarts == (restarts if format != "stim300" else 0)


TRUTH = Truth(sample_period_s=0.02)
WIRE = FORMATS["counts"]


def recorded(path: Path, silent_s: float, lasts_s: float) -> str:
    """Write what a unit sent that says who it is only after ``silent_s``, and return its address."""
    device, writer = ByteDevice(TRUTH, 1, WIRE), StepWriter(path)
    assert WIRE.encode_identity is not None
    reported = WIRE.encode_identity(Identity(TRUTH.model, TRUTH.serial, TRUTH.sample_period_s))
    while (now := device.imu.time) < lasts_s:
        parts = [
            part for part in device.chunk(5) if isinstance(part, bytes) and (now >= silent_s or part != reported)
        ]
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
