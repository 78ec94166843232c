"""A live feed in memory: another source, temperature, pulses, pieces, and a format that is found."""

import time

import pytest

from drivers.errors import BadDeviceUrl, LinkSilent, ReplayEnded, WrongFormat
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from procedures.error_codes import ErrorCode
from station.errors import DataRefused
from station.stream.live.live_feed import LiveFeed, open_feed
from station.stream.reader import Chunk
from tests.refusals import refused
from tests.station.stream.live.bench_in_memory import Source
from tests.station.stream.live.scripted_feed import GONE, NOISE, Item, Script, chunks, device


def test_a_pulse_is_handed_over_once_with_the_device_time_at_which_it_came() -> None:
    feed = LiveFeed(source := Source(Truth(sample_period_s=0.01), format="rawimus", pps=True), FORMATS["rawimus"])
    while source.device.imu.time < 3.2:
        feed.advance()
    assert feed.stamp is not None
    assert feed.pulse_age is not None
    host_ns, at = feed.stamp
    assert host_ns == round(source.device.imu.time * 1e9)
    newest = at - feed.pulse_age
    found = feed.pulses(newest - 0.5)
    assert sorted({round(each - newest, 3) for each in found}) == [-3.0, -2.0, -1.0]
    assert not feed.pulses(newest - 0.5)
    left = feed.pulses(newest + 1e-9)
    assert left
    assert left == pytest.approx([newest] * len(left))
    assert not feed.pulses(1e9)


@pytest.mark.parametrize(
    ("url", "option"),
    [("mavlink:udpin:127.0.0.1:1455", "--gnss"), ("camera:http://127.0.0.1:50/x", "--camera")],
)
def test_the_address_of_something_else_is_refused_with_the_option_that_takes_it(url: str, option: str) -> None:
    with refused(BadDeviceUrl, ErrorCode.DEVICE_ADDRESS, option):
        open_feed(Script(url=url))


SNIFFED = "serial:///dev/imu"


def test_a_format_is_found_by_three_frames_and_these_are_the_first_samples() -> None:
    script = Script([(0.0, [each]) for each in chunks(device(format="rawimus"), 5)], SNIFFED)
    feed = open_feed(script)
    assert feed.wire.name == "rawimus"
    assert (feed.buffer.end, len(script.polls)) == (3, 2)
    assert [len(piece.block) for piece, _ in zip(feed.pieces(), range(3), strict=False)] == [1, 1, 1]


@pytest.mark.parametrize(
    ("items", "error", "said"),
    [
        ([], LinkSilent, "1.8 s"),
        ([Chunk(1, NOISE), GONE, Chunk(2, NOISE)], WrongFormat, "128 bytes at 921600 baud"),
    ],
)
def test_a_format_that_is_not_found_in_time_is_refused(
    items: list[Item], error: type[Exception], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = Script([(0.0, [each]) for each in items], SNIFFED)
    monkeypatch.setattr(time, "monotonic", script.clock)
    with refused(error, ErrorCode.DEVICE, said):
        open_feed(script)
    assert 1.8 <= script.now < 1.95


def test_a_recording_that_ends_before_its_format_is_found_is_refused() -> None:
    class Ended(Script):
        def poll(self, timeout_s: float) -> list[Item]:
            raise ReplayEnded("a.mcap", 7)

    with refused(DataRefused, None, "7 bytes"):
        open_feed(Ended(url=SNIFFED))
