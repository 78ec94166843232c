"""Frames to samples, number by number: a device of two frames a sample and a third that comes now and then."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.can import frame_record
from drivers.can.dbc_signals import SignalField
from drivers.can.frame_joiner import CanJoiner
from drivers.can.frame_record import RECORD
from drivers.can.mapping_file import CanMap, Slot
from drivers.wire import FrameCounters
from procedures.counts.sample_records import RateBlock, SampleBlock

COUNTER, BYTE_1 = SignalField(0, 8), SignalField(8, 8)
WORDS = [SignalField(16 * i, 16, is_signed=True) for i in (1, 2, 3)]
TEMPERATURE = SignalField(8, 8, scale=0.5, offset=-40.0)
A, B, ASIDE = 0x10, 0x11, 0x05
PERIOD = 10_000_000  # ns
SIZE = RECORD.itemsize


def slot(name: str, identifier: int, first: int, **fields: object) -> Slot:
    none = dict.fromkeys(("status", "check", "time", "temperature"))
    channels = tuple((first + i, field) for i, field in enumerate(WORDS)) if first >= 0 else ()
    given: dict[str, object] = {"counter": COUNTER, **none, **fields}
    return Slot(name, identifier, 8, channels, is_needed=first >= 0, **given)  # type: ignore[arg-type]


SLOTS = (
    slot("A", A, 0, status=BYTE_1),
    slot("B", B, 3, temperature=TEMPERATURE),
    slot("ASIDE", ASIDE, -1, temperature=TEMPERATURE),
)
MAP = CanMap(
    name="two", title="", output="increments", period=0.01, slots=SLOTS, counts_every_frame=True, first=0,
    fault_bits=0b0110, good_bits=0b0001, check_kind="", time_unit=1.0, is_padded=False, max_step=None,
)  # fmt: skip


def frame(identifier: int, u: int, host: float | None = None, byte_1: int = 1, payload: int = 0) -> bytes:
    """Return frame ``u``, sent at u periods; its words are u + payload and what is next to it."""
    words = np.array([u % 1000 + payload, identifier % 0x800, -u % 1000], "<i2").tobytes()
    at = round((u if host is None else host) * PERIOD) + (identifier == B) * 1000
    return frame_record.pack(identifier, at, bytes((u % 256, byte_1)) + words)


def both(*us: int) -> list[bytes]:
    return [frame(each, u) for u in us for each in (A, B)]


class Fed:
    """A joiner, its counters, and what it gave out."""

    def __init__(self, can_map: CanMap = MAP) -> None:
        self.counters = FrameCounters()
        self.joiner, self.at = CanJoiner(can_map, self.counters), 0

    def take(self, frames: list[bytes], apart: int = SIZE) -> tuple[SampleBlock, list[list[int]]]:
        records: NDArray[np.void] = np.frombuffer(b"".join(frames), RECORD)
        at = self.at + apart * np.arange(len(frames))
        self.at += apart * len(frames)
        block, edges = self.joiner.take(records, at)
        return block, edges.tolist()


def numbers(block: SampleBlock) -> list[int]:
    return np.rint(block.device_time / 0.01).astype(int).tolist()


def test_a_sample_holds_the_words_of_its_frames_and_its_bytes() -> None:
    fed = Fed()
    block, edges = fed.take(both(7, 8))
    assert block.gyro.tolist() == [[7, A, -7 % 1000], [8, A, -8 % 1000]]
    assert block.accel.tolist() == [[7, B, -7 % 1000], [8, B, -8 % 1000]]
    assert block.counter.tolist() == [7, 8]
    np.testing.assert_allclose(block.device_time, [0.07, 0.08])
    assert block.temperature.tolist() == [-39.5, -39.5]  # 1 * 0.5 - 40
    assert edges == [[0, 2 * SIZE], [2 * SIZE, 4 * SIZE]]
    assert fed.counters == FrameCounters()


def test_frames_may_come_in_either_order() -> None:
    block, edges = Fed().take([frame(B, 3), frame(A, 3), frame(A, 4), frame(B, 4)])
    assert (block.gyro[:, 1].tolist(), block.accel[:, 1].tolist()) == ([A, A], [B, B])
    assert edges == [[0, 2 * SIZE], [2 * SIZE, 4 * SIZE]]


@pytest.mark.parametrize(
    ("status", "is_healthy"), [(1, True), (0, False), (3, False), (5, False), (9, True), (8, False)]
)
def test_healthy_is_all_good_bits_and_no_fault(status: int, is_healthy: bool) -> None:
    block, _ = Fed().take([frame(A, 1, byte_1=status), frame(B, 1)])
    assert block.healthy.tolist() == [is_healthy]
    assert block.status.tolist() == [status]


def test_the_counter_is_unwrapped_by_the_hosts_clock() -> None:
    fed = Fed()
    assert numbers(fed.take(both(254, 255, 256, 257))[0]) == [254, 255, 256, 257]
    assert numbers(fed.take(both(257 + 5 * 256))[0]) == [257 + 5 * 256]
    late = 257 + 7 * 256
    assert numbers(fed.take([frame(each, late, late - 120) for each in (A, B)])[0]) == [late]


def test_a_frame_may_be_a_sample_late_and_is_given_up_at_two() -> None:
    fed = Fed()
    block, edges = fed.take([*both(1), frame(A, 2), *both(3), frame(B, 2)])
    assert numbers(block) == [1, 2, 3]  # 3 was whole before 2 and has waited for it
    assert edges == [[0, 2 * SIZE], [2 * SIZE, 6 * SIZE], [3 * SIZE, 6 * SIZE]]
    assert len(fed.take([frame(A, 4), frame(B, 5)])[0]) == 0
    block, edges = fed.take([frame(B, 4), frame(A, 5)])
    assert numbers(block) == [4, 5]
    assert edges == [[6 * SIZE, 9 * SIZE], [7 * SIZE, 10 * SIZE]]
    fed = Fed()
    block, _ = fed.take([*both(1), frame(A, 2), *both(3), frame(A, 4), frame(B, 4), frame(B, 2)])
    assert numbers(block) == [1, 3, 4]
    assert (fed.counters.incomplete, fed.counters.late, fed.counters.contradicted) == (1, 1, 0)


def test_a_frame_that_comes_twice_alike_is_late_and_otherwise_is_not_believed() -> None:
    fed = Fed()
    block, _ = fed.take([frame(A, 1), frame(A, 1), frame(B, 1), *both(2)])
    assert numbers(block) == [1, 2]
    assert (fed.counters.incomplete, fed.counters.late, fed.counters.contradicted) == (0, 1, 0)
    fed = Fed()
    block, _ = fed.take([*both(1), frame(A, 2), frame(A, 2, payload=5), frame(B, 2), *both(3)])
    assert numbers(block) == [1, 3]
    assert (fed.counters.incomplete, fed.counters.late, fed.counters.contradicted) == (1, 1, 1)


@pytest.mark.parametrize(
    ("padded", "size", "good"),
    [(False, 7, 0), (False, 8, 1), (False, 9, 0), (True, 7, 0), (True, 8, 1), (True, 9, 0)],
)
def test_a_length_is_its_own_or_longer_where_payloads_are_padded(padded: bool, size: int, good: int) -> None:
    fed = Fed(replace(MAP, is_padded=padded))
    data = bytes((1, 1, 0, 0, 0, 0, 0, 0, 0))[:size]
    block, _ = fed.take([frame_record.pack(A, PERIOD, data), frame(B, 1)])
    assert len(block) == good
    assert fed.counters.bad_length == 1 - good


def checked(identifier: int, u: int, wrong: int = 0, size: int = 8) -> bytes:
    data = bytearray(frame(identifier, u)[18:26])
    data = bytearray((u, 0, *data[2:]))
    data[1] = int(np.bitwise_xor.reduce(np.frombuffer(bytes(data), np.uint8))) ^ wrong
    return frame_record.pack(identifier, u * PERIOD, bytes(data)[:size])


def test_a_check_is_over_all_bytes_but_its_own() -> None:
    slots = tuple(replace(each, status=None, temperature=None, check=BYTE_1) for each in SLOTS[:2])
    for check in (BYTE_1, SignalField(15, 8, is_big_endian=True)):
        fed = Fed(replace(MAP, check_kind="xor8", slots=tuple(replace(each, check=check) for each in slots)))
        block, _ = fed.take(
            [checked(A, 1), checked(B, 1), checked(A, 2, wrong=4), checked(B, 2), checked(A, 3, size=7)]
        )
        assert numbers(block) == [1]
        assert (fed.counters.bad_crc, fed.counters.bad_length) == (1, 1)


def test_a_temperature_that_comes_now_and_then_is_of_its_sample() -> None:
    slots = (SLOTS[0], replace(SLOTS[1], temperature=None), SLOTS[2])
    fed = Fed(replace(MAP, slots=slots))
    block, edges = fed.take([*both(1), frame(ASIDE, 2, byte_1=100), *both(2, 3)])
    np.testing.assert_array_equal(block.temperature, [np.nan, 10.0, np.nan])
    assert edges == [[0, 2 * SIZE], [2 * SIZE, 5 * SIZE], [5 * SIZE, 7 * SIZE]]
    block, edges = fed.take([frame(A, 4), frame(ASIDE, 5, byte_1=90), frame(B, 4)])
    assert np.isnan(block.temperature).all()
    block, edges = fed.take(both(5))
    assert block.temperature.tolist() == [5.0]  # it waited for its sample
    assert edges == [[8 * SIZE, 12 * SIZE]]
    block, edges = fed.take([*both(6), frame(ASIDE, 6, byte_1=80)])
    assert block.temperature.tolist() == [0.0]
    assert edges == [[12 * SIZE, 14 * SIZE]]


def test_rates_are_in_their_units() -> None:
    rate = tuple(
        replace(each, channels=tuple((i, replace(field, scale=0.25, offset=1.0)) for i, field in each.channels))
        for each in SLOTS
    )
    block, _ = Fed(replace(MAP, output="rate", slots=rate)).take(both(8))
    assert isinstance(block, RateBlock)
    assert block.gyro.tolist() == [[3.0, 5.0, 249.0]]  # 8, 16, 992


def test_running_totals_are_distinguished_by_the_sample_before() -> None:
    fed = Fed(replace(MAP, output="cumulative"))

    def total(u: int, value: int) -> list[bytes]:
        words = np.array([value, -value, 0], "<i4").astype("<i2").tobytes()
        return [frame_record.pack(each, u * PERIOD, bytes((u, 1)) + words) for each in (A, B)]

    block, edges = fed.take([*total(1, 30000), *total(2, 32000), *total(3, -32536)])  # wraps at 2**15
    assert block.gyro.tolist() == [[2000, -2000, 0], [1000, -1000, 0]]
    assert block.accel.tolist() == block.gyro.tolist()
    assert edges == [[0, 4 * SIZE], [2 * SIZE, 6 * SIZE]]  # what it is the difference of
    assert block.counter.tolist() == [2, 3]
    block, edges = fed.take([*total(4, -32530), *total(6, 100), *total(7, 90)])
    assert block.gyro[:, 0].tolist() == [6, -10]
    assert block.counter.tolist() == [4, 7]
    assert edges == [[4 * SIZE, 8 * SIZE], [8 * SIZE, 12 * SIZE]]
    assert len(fed.take([total(8, 0)[0]])[0]) == 0


def test_a_time_signal_is_unwrapped_in_its_unit() -> None:
    slots = (replace(SLOTS[0], status=None, time=BYTE_1), replace(SLOTS[1], temperature=None))
    fed = Fed(replace(MAP, slots=slots, time_unit=0.004))
    frames = [each for u, t in ((1, 250), (2, 255), (3, 4)) for each in (frame(A, u, byte_1=t), frame(B, u))]
    np.testing.assert_allclose(fed.take(frames)[0].device_time, np.multiply([250, 255, 260], 0.004))
    block, _ = fed.take([frame(A, 4, byte_1=9), frame(B, 4)])
    np.testing.assert_allclose(block.device_time, [265 * 0.004])
