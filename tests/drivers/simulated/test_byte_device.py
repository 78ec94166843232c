"""A simulated device without a line: how much it says at once, when its hands move, and what they answer."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from drivers.framing import Decoder
from drivers.simulated.device import ByteDevice, ScheduledMove, pulsed
from drivers.simulated.errors import TruthRefused
from drivers.simulated.imu import SimulatedImu
from drivers.simulated.line_faults import Fault, Silence
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS, Identity

TRUTH = Truth(sample_period_s=0.02)
SLOW = Truth(sample_period_s=0.25, serial="S7", model="M")
COUNTS = FORMATS["counts"]


def identity(truth: Truth) -> bytes:
    assert COUNTS.encode_identity is not None
    return COUNTS.encode_identity(Identity(truth.model, truth.serial, truth.sample_period_s))


@pytest.mark.parametrize(("most", "samples"), [(7, 7), (1, 1), (50, 50), (1000, 50)])
def test_a_chunk_is_of_as_many_samples_as_asked_for_up_to_the_next_second(most: int, samples: int) -> None:
    device = ByteDevice(TRUTH, None, "counts")
    device.chunk(most)
    assert device.samples == samples


def test_a_chunk_is_of_fifty_samples_where_none_is_asked_for() -> None:
    device = ByteDevice(Truth(sample_period_s=0.01), None, "counts")
    device.chunk()
    assert device.samples == 50


def test_who_it_is_is_said_once_a_second() -> None:
    device, said = ByteDevice(SLOW, None, "counts"), list[int]()
    sizes = list[int]()
    for _ in range(6):
        before = device.samples
        sent = b"".join(part for part in device.chunk(3) if isinstance(part, bytes))
        if sent.startswith(identity(SLOW)):
            said.append(before)
        assert sent.count(identity(SLOW)) == (before in {0, 4, 8})
        sizes.append(device.samples - before)
    assert (said, sizes) == ([0, 4, 8], [3, 1, 3, 1, 3, 1])


def test_a_device_slower_than_a_second_says_who_it_is_with_every_sample() -> None:
    slow = Truth(sample_period_s=2.5)
    device = ByteDevice(slow, None, "counts")
    for _ in range(3):
        assert device.chunk(5)[0] == identity(slow)
    assert device.samples == 3


def test_a_format_that_has_no_identity_sends_none() -> None:
    device = ByteDevice(TRUTH, None, "kvh1750")
    sent = b"".join(part for part in device.chunk(4) if isinstance(part, bytes))
    assert len(sent) == 4 * FORMATS["kvh1750"].frame.itemsize
    assert sent == FORMATS["kvh1750"].encode(SimulatedImu(TRUTH, None).read_rates(4))


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
        ("lean 1 2 -3", lambda imu: imu.lean(np.array([1.0, 2.0, -3.0]))),
        ("lean 1 2 -3 2", lambda imu: imu.lean(np.array([1.0, 2.0, -3.0]), 2.0)),
        ("heat 20 5", lambda imu: imu.heat(20.0, 5.0)),
        ("knock 0.5 2", lambda imu: imu.knock(0.5, 2.0)),
        ("creep 2 1 2 -3", lambda imu: imu.creep(2.0, np.radians([1.0, 2.0, -3.0]))),
        ("turn x + 1", lambda imu: imu.turn("x", "+", 1)),
        ("turn x - 1 2", lambda imu: imu.turn("x", "-", 1, 2.0)),
        ("rest 1.5", lambda imu: imu.rest(1.5)),
    ],
)
def test_a_command_does_what_the_hand_does(command: str, does: Callable[[SimulatedImu], None]) -> None:
    device, hand = ByteDevice(Truth.example(2), 3, "counts"), SimulatedImu(Truth.example(2), 3)
    assert device.obey(command).startswith("ok time 0.000000 done ")
    does(hand)
    assert device.imu.done == hand.done
    ours, theirs = device.imu.read(250), hand.read(250)
    np.testing.assert_array_equal(ours.gyro, theirs.gyro)
    np.testing.assert_array_equal(ours.accel, theirs.accel)
    np.testing.assert_array_equal(ours.temperature, theirs.temperature)


@pytest.mark.parametrize(
    "command",
    [
        "", "place", "place 3 2 1", "place 3 2 1 2", "place 3 2 1 2 3 4", "carry 5", "carry 5 2",
        "carry 5 2 30 1 1", "lean 1 2", "lean 1 2 3 4 5", "heat 20", "knock 1", "creep 2", "creep 2 1 2",
        "creep 2 1 2 3 4",
        "turn z +", "turn z + 1 2 3", "rest", "rest 1 2", "time 1", "status 1",
    ],
)  # fmt: skip
def test_a_command_of_another_form_is_answered_by_all_forms(command: str) -> None:
    device = ByteDevice(TRUTH, None, "counts")
    assert device.obey(command) == (
        f"error unknown command {command!r}; expected place POSITION [MOVE_S [X_DEG Y_DEG Z_DEG]], "
        "carry POSITION MOVE_S TREMOR_DEG_S [PAUSE_S], lean X Y Z [MOVE_S], "
        "turn AXIS + or - REVOLUTIONS [REST_S], rest SECONDS, heat KELVIN TAU_S, knock SECONDS SIZE_G, "
        "creep SECONDS X_DEG Y_DEG Z_DEG, status, time or go"
    )
    assert device.imu.done == 0.0


def test_time_and_status_are_told() -> None:
    device = ByteDevice(TRUTH, None, "counts")
    assert device.obey("status") == "ok position 1 resting time 0.000000 done 0.000000"
    device.obey("rest 1.5")
    device.chunk(25)
    assert device.obey("time") == "ok 0.500000"
    assert device.obey("status") == "ok position 1 moving time 0.500000 done 1.500000"


def test_what_the_hand_refuses_is_answered_in_one_line() -> None:
    device = ByteDevice(TRUTH, None, "counts")
    assert device.obey("place 25") == "error position 25: expected 1 to 24"
    assert "\n" not in device.obey("rest x\ny")
    assert device.obey("rest x").startswith("error ")


def test_a_planted_fault_acts_from_the_next_sample_on() -> None:
    device = ByteDevice(SLOW, None, "counts")
    device.chunk(2)
    device.plant("lost", 2)
    assert b"".join(part for part in device.chunk(2) if isinstance(part, bytes)) == b""
    after = b"".join(part for part in device.chunk(3) if isinstance(part, bytes))
    assert Decoder(COUNTS).feed(after).counter.tolist() == [4, 5, 6]


def test_a_planted_fault_is_one_frame_unless_more_are_asked_for() -> None:
    device = ByteDevice(SLOW, None, "counts")
    device.chunk(1)
    device.plant("lost")
    sent = b"".join(part for part in device.chunk(3) if isinstance(part, bytes))
    assert Decoder(COUNTS).feed(sent).counter.tolist() == [2, 3]


def test_no_seed_spoils_its_line_as_a_seed_of_nought_does() -> None:
    noise = Fault("noise", 0.0, seconds=5.0)
    sent = [ByteDevice(TRUTH, seed, "counts", [noise]).chunk(3) for seed in (None, 0, 1)]
    assert sent[0] == sent[1] != sent[2]


def test_a_planted_silence_is_as_long_as_it_was_said() -> None:
    device = ByteDevice(TRUTH, None, "counts")
    device.chunk(2)
    device.plant("stall", seconds=3.5)
    assert [part for part in device.chunk(2) if isinstance(part, Silence)] == [Silence(3.5, "stall")]
    other = ByteDevice(TRUTH, None, "counts")
    other.plant("stall")
    assert [part for part in other.chunk(2) if isinstance(part, Silence)] == [Silence(1.0, "stall")]


@pytest.mark.parametrize("clock_ppm", [0.0, 1e5])
def test_a_pulse_is_a_whole_second_of_true_time(clock_ppm: float) -> None:
    """A clock a tenth too fast: its 1.1 s are a true second, its 1.65 s half a second later: 0.55 of its own."""
    stim = FORMATS["stim300"]
    assert stim.pulse is not None
    pace = 1 + clock_ppm * 1e-6
    block = replace(SimulatedImu(TRUTH, None).read(3), device_time=pace * np.array([0.25, 1.0 + 1e-9, 1.5]))
    sent = pulsed(stim, clock_ppm).encode(block)
    size = len(sent) // 3
    told = [stim.pulse.age(sent[: size * (i + 1)], 0.0) for i in range(3)]
    assert told == pytest.approx([0.25 * pace, 0.0, 0.5 * pace], abs=1.1e-6)


def test_a_format_that_tells_of_no_pulse_is_refused_with_those_that_do() -> None:
    with pytest.raises(TruthRefused, match=r"a pulse with format counts.*a format that tells of one: ") as error:
        ByteDevice(TRUTH, None, "counts", pps=True)
    names = str(error.value).rpartition(": ")[2].split(", ")
    assert names == [name for name, wire in FORMATS.items() if wire.pulse is not None]
    assert "stim300" in names
