"""A device on a real pty and on TCP, against the same device read in memory; its pace."""

import time
from pathlib import Path

import numpy as np
import pytest

from drivers.errors import ControlRefused, LinkLost
from drivers.framing import Decoder
from drivers.port_interface import Port
from drivers.ports import open_port
from drivers.simulated.bench_control import BenchControl
from drivers.simulated.faults import Fault
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.server import MAX_BEHIND_S, Pace, SimulatedDevice
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from procedures.counts.sample_records import SampleBlock
from tests.drivers.wire.blocks import CHANNELS
from tests.patience import HANG_S

TRUTH = Truth.example(1)
every_transport = pytest.mark.parametrize("transport", ["pty", "tcp"])


def received(port: Port, frames: int, decoder: Decoder) -> list[SampleBlock]:
    """Read until ``frames`` have come; fail loudly rather than hang."""
    blocks, until = list[SampleBlock](), time.monotonic() + HANG_S
    while sum(map(len, blocks)) < frames:
        assert time.monotonic() < until, f"{sum(map(len, blocks))} of {frames} frames"
        blocks.append(decoder.feed(port.read(65536)))
    return blocks


@pytest.mark.parametrize(("transport", "name"), [("tcp", "counts"), *(("pty", name) for name in sorted(FORMATS))])
def test_bytes_read_from_the_port_decode_to_the_counts_in_memory(transport: str, name: str) -> None:
    memory = SimulatedImu(TRUTH, 5)
    with SimulatedDevice(TRUTH, 5, name, speed=0, transport=transport, hold=True) as device:
        with BenchControl(device.control) as hands:
            for hand in (memory, hands):
                hand.place(3, 10.0)
                hand.turn("x", "+", 1, 2.0)
                hand.rest(3.0)
            assert hands.done() == pytest.approx(memory.done)
            port = open_port(device.url)
            hands.go()
            decoder = Decoder(FORMATS[name])
            blocks = received(port, 2000, decoder)
            port.close()
    wire = FORMATS[name]
    expected = memory.read_rates(2000) if wire.output == "rate" else memory.read(2000)
    for field, channels in CHANNELS.items():
        got = np.concatenate([getattr(block, field) for block in blocks])[:2000]
        want = getattr(expected, field).astype(np.float32 if wire.output == "rate" else np.int64)
        want[:, [channel not in wire.imu.channels for channel in channels]] = 0
        assert np.array_equal(got, want), field
        assert (got != 0).any() == (field in wire.imu.triads)
    assert decoder.counters.skipped_bytes == decoder.counters.bad_crc == decoder.counters.counter_jumps == 0
    if name == "counts":
        assert decoder.serial == TRUTH.serial


def test_hands_answer_errors_and_the_device_lives_on() -> None:
    with SimulatedDevice(TRUTH, 1, speed=0) as device, BenchControl(device.control) as hands:
        for command in ("fly", "place", "place 25", "place x", "turn y + 3", "rest -1", ""):
            with pytest.raises(ControlRefused):
                hands.say(command)
        assert hands.place(2) > hands.time() >= 0
        assert hands.say("status")[:3] == ["position", "2", "moving"]
    with pytest.raises(ControlRefused):
        BenchControl(device.control).time()


@every_transport
def test_a_reader_may_leave_and_another_come(transport: str) -> None:
    with SimulatedDevice(TRUTH, 1, speed=0, transport=transport) as device:
        ends = []
        for _ in range(2):
            port, decoder = open_port(device.url), Decoder(FORMATS["counts"])
            ends.append(received(port, 200, decoder)[-1].device_time[-1])
            port.close()
        assert ends[1] > ends[0]
        assert device.failure is None


@every_transport
def test_an_unplugged_port_is_lost_and_comes_back_under_the_same_url(transport: str, tmp_path: Path) -> None:
    fault = Fault("unplug", 4.0, seconds=0.2)
    link = tmp_path / "imu" if transport == "pty" else None
    with SimulatedDevice(TRUTH, 1, speed=0, transport=transport, link=link, faults=[fault], hold=True) as device:
        url, decoder = device.url, Decoder(FORMATS["counts"])
        port = open_port(url)
        with BenchControl(device.control) as hands:
            hands.go()
        before = list[SampleBlock]()
        with pytest.raises(LinkLost):
            before += received(port, 100_000, decoder)
        port.close()
        port, decoder = reopened(url), Decoder(FORMATS["counts"])
        after = received(port, 100, decoder)
        port.close()
    counter = np.concatenate([block.counter for block in after])
    assert counter[0] >= 210, "what was taken while unplugged is lost"


def reopened(url: str) -> Port:
    until = time.monotonic() + HANG_S
    while True:
        try:
            return open_port(url)
        except OSError:
            assert time.monotonic() < until, f"{url} did not come back"


def test_a_paced_device_sends_too() -> None:
    with SimulatedDevice(TRUTH, 1, speed=1000.0) as device:
        port = open_port(device.url)
        blocks = received(port, 2000, Decoder(FORMATS["counts"]))
        port.close()
    counter = np.concatenate([block.counter for block in blocks])
    assert np.all(np.diff(counter) == 1), "opening drops what came before it, nothing after"


class Clock:
    now = 100.0

    def __call__(self) -> float:
        return self.now


def test_deadlines_are_absolute_and_a_late_wake_up_is_caught_up() -> None:
    clock = Clock()
    pace = Pace(2.0, 0.02, clock)
    assert pace.delay(100) == pytest.approx(1.0)
    clock.now += 1.1  # woke 0.1 s late
    assert pace.delay(105) == 0.0
    assert pace.delay(120) == pytest.approx(0.1)


def test_a_device_that_fell_far_behind_restarts_its_pace() -> None:
    clock = Clock()
    pace = Pace(1.0, 0.02, clock)
    clock.now += 60.0
    assert pace.delay(50) == 0.0
    assert pace.delay(100) == pytest.approx(1.0)
    assert MAX_BEHIND_S < 60


def test_a_device_held_up_on_purpose_goes_on_at_its_time() -> None:
    clock = Clock()
    pace = Pace(1.0, 0.02, clock)
    pace.excuse(4.0)
    clock.now += 4.0
    assert pace.delay(1) == 0.0
    assert pace.delay(250) == pytest.approx(1.0)
    clock.now += 60.0  # once more, and not on purpose
    assert pace.delay(300) == 0.0
    assert pace.delay(350) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("speed", "period", "samples"),
    [(1.0, 0.001, 10), (1.0, 0.004, 2), (1.0, 0.5, 1), (2.0, 0.02, 4), (1.0, 1e-4, 50), (1.5, 0.03, 2)],
)
def test_a_chunk_is_of_ten_milliseconds_or_of_forty_when_faster_than_time(
    speed: float, period: float, samples: int
) -> None:
    assert Pace(speed, period, Clock()).samples == samples
