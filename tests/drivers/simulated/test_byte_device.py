"""A simulated device without a line: how much it says at once, when its hands move, and what they answer."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from drivers.framing import Decoder
from drivers.simulated.device import ByteDevice, ScheduledMove, pulsed
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS, Identity

TRUTH = Truth(sample_period_s=0.02)
SLOW = Truth(sample_period_s=0.25, serial="S7", model="M")
COUNTS = FORMATS["counts"]


def identity(truth: Truth) -> bytes:
    assert COUNTS.encode_identity is not None
    return COUNTS.encode_identity(Identity(truth.model, truth.serial, truth.sample_period_s))


def test_who_it_is_is_reported_once_a_second() -> None:
    device, reported = ByteDevice(SLOW, None, "counts"), list[int]()
    sizes = list[int]()
    for _ in range(6):
        before = device.samples
        sent = b"".join(part for part in device.chunk(3) if isinstance(part, bytes))
        if sent.startswith(identity(SLOW)):
            reported.append(before)
        assert sent.count(identity(SLOW)) == (before in {0, 4, 8})
        sizes.append(device.samples - before)
    assert (reported, sizes) == ([0, 4, 8], [3, 1, 3, 1, 3, 1])


def test_its_samples_are_those_of_the_imu() -> None:
    device = ByteDevice(TRUTH, 4, "counts")
    sent = b"".join(part for part in device.chunk(9) if isinstance(part, bytes))
    assert sent == identity(device.truth) + COUNTS.encode(SimulatedImu(TRUTH, 4).read(9))


def test_moves_act_on_the_sample_of_their_time() -> None:
    moves = [ScheduledMove(0.1, "place 3 10"), ScheduledMove(0.1, "rest 5"), ScheduledMove(0.3, "fly")]
    device = ByteDevice(TRUTH, None, "counts", moves=moves)
    device.chunk(20)
    assert (device.samples, device.moved) == (5, [])
    device.chunk(20)
    assert device.samples == 15
    hand = SimulatedImu(TRUTH, None)
    hand.read(5)
    hand.place(3, 10.0)
    placed = hand.done
    hand.rest(5.0)
    assert device.moved == [
        ("place 3 10", f"ok time 0.100000 done {placed:.6f}"),
        ("rest 5", f"ok time 0.100000 done {hand.done:.6f}"),
    ]
    device.chunk(20)
    assert device.samples == 35
    command, answer = device.moved[2]
    assert command == "fly"
    assert answer.startswith("error unknown command 'fly'; expected place POSITION")


@pytest.mark.parametrize(
    ("command", "does"),
    [
        ("place 3", lambda imu: imu.place(3)),
        ("place 3 2", lambda imu: imu.place(3, 2.0)),
        ("place 3 2 1 -2 3", lambda imu: imu.place(3, 2.0, np.radians([1.0, -2.0, 3.0]))),
        ("carry 5 2 30", lambda imu: imu.carry(5, 2.0, 30.0)),
        ("carry 5 2 30 0.5", lambda imu: imu.carry(5, 2.0, 30.0, 0.5)),
        ("tilt 1 2 -3", lambda imu: imu.tilt(np.array([1.0, 2.0, -3.0]))),
        ("lean 1 2 -3 2", lambda imu: imu.tilt(np.array([1.0, 2.0, -3.0]), 2.0)),
        ("heat 20 5", lambda imu: imu.heat(20.0, 5.0)),
        ("shock 0.5 2", lambda imu: imu.shock(0.5, 2.0)),
        ("knock 0.5 2", lambda imu: imu.shock(0.5, 2.0)),  # as it was called in version 1.0
        ("creep 2 1 2 -3", lambda imu: imu.creep(2.0, np.radians([1.0, 2.0, -3.0]))),
        ("turn x + 1", lambda imu: imu.turn("x", "+", 1)),
        ("turn x - 1 2", lambda imu: imu.turn("x", "-", 1, 2.0)),
        ("rest 1.5", lambda imu: imu.rest(1.5)),
    ],
)
def test_a_command_does_what_the_hand_does(command: str, does: Callable[[SimulatedImu], None]) -> None:
    device, hand = ByteDevice(Truth.example(2), 3, "counts"), SimulatedImu(Truth.example(2), 3)
    assert device.execute(command).startswith("ok time 0.000000 done ")
    does(hand)
    assert device.imu.done == hand.done
    ours, theirs = device.imu.read(250), hand.read(250)
    np.testing.assert_array_equal(ours.gyro, theirs.gyro)
    np.testing.assert_array_equal(ours.accel, theirs.accel)
    np.testing.assert_array_equal(ours.temperature, theirs.temperature)


def test_a_planted_fault_acts_from_the_next_sample_on() -> None:
    device = ByteDevice(SLOW, None, "counts")
    device.chunk(2)
    device.plant("lost", 2)
    assert b"".join(part for part in device.chunk(2) if isinstance(part, bytes)) == b""
    after = b"".join(part for part in device.chunk(3) if isinstance(part, bytes))
    assert Decoder(COUNTS).feed(after).counter.tolist() == [4, 5, 6]


@pytest.mark.parametrize("clock_ppm", [0.0, 1e5])
def test_a_pulse_is_a_whole_second_of_true_time(clock_ppm: float) -> None:
    """A clock a tenth too fast: its 1.1 s are a true second, its 1.65 s half a second later: 0.55 of its own."""
    stim = FORMATS["stim300"]
    assert stim.pulse is not None
    pace = 1 + clock_ppm * 1e-6
    block = replace(SimulatedImu(TRUTH, None).read(3), device_time=pace * np.array([0.25, 1.0 + 1e-9, 1.5]))
    sent = pulsed(stim, clock_ppm).encode(block)
    size = len(sent) // 3
    ages = [stim.pulse.age(sent[: size * (i + 1)], 0.0) for i in range(3)]
    assert ages == pytest.approx([0.25 * pace, 0.0, 0.5 * pace], abs=1.1e-6)
