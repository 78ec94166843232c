"""Messages read as columns are what they are one by one, or are not read so."""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from google.protobuf.message import DecodeError
from hypothesis import given
from hypothesis import strategies as st

from procedures.gnss_records import FixType, GnssFix
from station.files.mcap_files import StepWriter, read_step
from station.files.mcap_files.gnss_file import FixWriter, read_fixes
from station.files.mcap_files.messages import columns
from station.files.mcap_files.schemas import COUNTS, MESSAGES, RATES, RAW_TOPIC
from station.stream.reader.messages import Chunk
from station.stream.reader.raw_recording import RawRecording
from tests.station.files.mcap_files.test_mcap_files import HOST, block

WHOLE = st.integers(-(2**63), 2**63 - 1) | st.just(0)
REAL = st.floats(allow_nan=False) | st.just(0.0)
FIELDS = {
    "device_ns": WHOLE,
    "host_ns": WHOLE,
    "counter": st.integers(0, 2**32 - 1),
    "status": st.just(0),
    "temperature_c": REAL,
}


def samples(name: str) -> st.SearchStrategy[list[bytes]]:
    value = WHOLE if name == COUNTS else REAL
    triads = {each: st.lists(value, min_size=3, max_size=3) for each in ("gyro", "accel")}
    some = st.sets(st.sampled_from(sorted(triads)), min_size=1).flatmap(
        lambda held: st.lists(st.fixed_dictionaries(FIELDS | {each: triads[each] for each in held}), max_size=8)
    )
    return some.map(lambda rows: [MESSAGES[name](**row).SerializeToString() for row in rows])


@pytest.mark.parametrize("name", [COUNTS, RATES])
@given(st.data())
def test_columns_are_what_each_message_says(name: str, data: st.DataObject) -> None:
    messages = data.draw(samples(name))
    found = columns(name, messages)
    if found is None:  # a value that is the mark itself
        assert any(abs(float(v)) > 1e18 for m in messages for v in values(name, m))
        return
    read = [MESSAGES[name].FromString(message) for message in messages]
    for field, column in found.items():
        each = [getattr(message, field) for message in read]
        if column is None:
            assert not any(map(len, each))
        elif field in ("gyro", "accel"):
            assert np.array_equal(column, np.array([list(one) for one in each]))
        else:
            assert column.tolist() == each


def values(name: str, message: bytes) -> list[float]:
    read = MESSAGES[name].FromString(message)
    return [read.device_ns, read.host_ns, read.temperature_c, *read.gyro, *read.accel]


@given(samples(COUNTS).filter(bool), st.data())
def test_a_damaged_message_is_no_column_that_differs(messages: list[bytes], data: st.DataObject) -> None:
    at = data.draw(st.integers(0, len(messages) - 1))
    damaged = data.draw(st.binary(max_size=40)) if data.draw(st.booleans()) else messages[at][:-1]
    messages[at] = damaged
    found = columns(COUNTS, messages)
    if found is None:
        return
    try:
        read = [MESSAGES[COUNTS].FromString(message) for message in messages]
    except DecodeError:
        pytest.fail("columns of a message that cannot be read")
    assert found["device_ns"].tolist() == [message.device_ns for message in read]


def message(**fields: object) -> bytes:
    whole: bytes = MESSAGES[COUNTS](**fields).SerializeToString()
    return whole


@pytest.mark.parametrize(
    "unlike",
    [
        message(gyro=[1, 2]),
        message(gyro=[1, 2, 3], aux={"a": 1.0}),
        message(accel=[1, 2, 3]),
        message(),
        message(gyro=[1, 2, 3]) + message(device_ns=5) + message(device_ns=6),
    ],
)
def test_messages_that_are_not_of_one_kind_are_read_one_by_one(unlike: bytes) -> None:
    assert columns(COUNTS, [message(gyro=[1, 2, 3], device_ns=4), unlike]) is None


MAGIC = b"\x89MCAP0\r\n"


def step(path: Path) -> None:
    writer = StepWriter(path)
    writer.write_block(HOST, block(0, 100))
    writer.flush()
    writer.write_block(HOST + 1, block(100, 100))
    writer.close()


def fixes(path: Path) -> None:
    writer = FixWriter(path)
    for i in range(20):
        writer.write(GnssFix("HEARD", 1, HOST + i, FixType.FIX_3D, device_ns=i, latitude=0.8, longitude=0.2))
    writer.close()


def recording(path: Path) -> None:
    made = RawRecording(path, {"url": "here"}, lambda error: pytest.fail(str(error)), RAW_TOPIC)
    made.put(Chunk(HOST, b"abc"))
    made.close()


WRITERS: list[tuple[Callable[[Path], None], Callable[[Path], int]]] = [
    (step, lambda path: len(read_step(path))),
    (fixes, lambda path: len(read_fixes(path))),
    (recording, lambda path: len(read_step(path).raw)),
]


@pytest.mark.parametrize(("write", "number"), WRITERS)
def test_what_has_its_end_has_its_data_and_they_are_read_whatever_is_torn_of_the_index(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write: Callable[[Path], None], number: Callable[[Path], int]
) -> None:
    path, torn, synced, real = tmp_path / "a.mcap", tmp_path / "torn.mcap", list[bytes](), os.fsync

    def fsync(descriptor: int) -> None:
        real(descriptor)
        synced.append(path.read_bytes())

    monkeypatch.setattr(os, "fsync", fsync)
    write(path)
    whole, there = path.read_bytes(), number(path)
    data = max(len(content) for content in synced if not content.endswith(MAGIC))
    assert data < len(whole)
    for first in range(data, len(whole) - len(MAGIC), 256):
        last = min(first + 256, len(whole) - len(MAGIC))
        torn.write_bytes(whole[:first] + bytes(last - first) + whole[last:])
        assert number(torn) == there
