"""docs/reference/wire-format-counts.md and drivers/wire/counts.py say the same, to the byte."""

import re
import zlib

import numpy as np
import pytest

from drivers.wire import Identity, counts
from procedures.counts.sample_records import CountBlock
from tests.paths import ROOT

PAGE = (ROOT / "docs/reference/wire-format-counts.md").read_text(encoding="utf-8")
EXAMPLES = [bytes.fromhex(line) for line in re.findall(r"^EB 90[ 0-9A-F]+$", PAGE, re.MULTILINE)]
TYPES = {"u8": "u1", "u16": "<u2", "u32": "<u4", "u64": "<u8", "i16": "<i2", "i32": "<i4"}


def block(counter: int, time_s: float, gyro: list[int], accel: list[int], temp: float, status: int) -> CountBlock:
    return CountBlock(
        counter=np.array([counter]),
        device_time=np.array([time_s]),
        gyro=np.array([gyro]),
        accel=np.array([accel]),
        temperature=np.array([temp]),
        status=np.array([status]),
        healthy=np.array([(status & 0xFF) == 0]),
    )


def test_the_first_example_is_the_golden_frame() -> None:
    assert EXAMPLES[0] == counts.FORMAT.example
    got = block(0x01020304, 123.456789012, [1, -2, 305419896], [-1, 20, -(2**31)], 25.37, 0x0100)
    assert counts.encode(got) == EXAMPLES[0]


def test_the_second_example_is_the_frame_at_the_limits() -> None:
    got = block(2**32 - 1, 10737418.2375, [-(2**31), 2**31 - 1, 0], [0, 0, 0], np.nan, 0x0048)
    assert counts.encode(got) == EXAMPLES[1]
    back = counts.decode(np.frombuffer(EXAMPLES[1], counts.FRAME))
    assert np.isnan(back.temperature).all()
    assert not back.healthy.any()


def test_the_third_example_is_the_identity_frame() -> None:
    assert EXAMPLES[2] == counts.encode_identity(Identity("FOG-3A", "0042", 0.0025))
    assert counts.identify(EXAMPLES[2]) == Identity("FOG-3A", "0042", 0.0025)
    assert len(EXAMPLES) == 3


@pytest.mark.parametrize(("title", "dtype"), [("IMU frame", counts.FRAME), ("Identity frame", counts.IDENTITY)])
def test_the_byte_table_is_the_dtype(title: str, dtype: np.dtype[np.void]) -> None:
    section = PAGE.split(f"## {title}: kind")[1].split("\n## ")[0]
    assert f", {dtype.itemsize} bytes" in section.splitlines()[0]
    rows = re.findall(r"^\| (\d+) \| (\w+)(?:\[(\d+)\])? \| (\w+) \|", section, re.MULTILINE)
    fields = []
    for offset, kind, size, name in rows:
        numpy_type = f"S{size}" if kind == "char" else TYPES[kind]
        shape = (int(size),) if size and kind != "char" else ()
        fields.append((name, np.dtype((numpy_type, shape)), int(offset)))
    assert dtype.fields is not None
    assert fields == [(name, *dtype.fields[name][:2]) for name in dtype.names or ()]


def test_the_check_value_on_the_page_is_the_crcs() -> None:
    assert "CBF43926" in PAGE
    assert zlib.crc32(b"123456789") == 0xCBF43926
    for frame in EXAMPLES:
        assert zlib.crc32(frame[:-4]) == int.from_bytes(frame[-4:], "little")
        assert f"CRC {zlib.crc32(frame[:-4]):08X} hex" in PAGE


def test_an_unhealthy_sample_without_a_fault_bit_is_sent_as_an_internal_fault() -> None:
    got = block(0, 0.0, [0, 0, 0], [0, 0, 0], 20.0, 0x8000)
    got.healthy[:] = False
    assert counts.decode(np.frombuffer(counts.encode(got), counts.FRAME)).status == 0x8080


@pytest.mark.parametrize(
    ("name", "value"),
    [("counter", -1), ("device_time", np.nan), ("device_time", -1.0), ("temperature", 400.0), ("status", 2**16)],
)
def test_what_the_frame_cannot_hold_is_refused(name: str, value: float) -> None:
    got = block(0, 0.0, [0, 0, 0], [0, 0, 0], 20.0, 0)
    getattr(got, name)[:] = value
    with pytest.raises(ValueError, match=name):
        counts.encode(got)


def test_an_unprintable_name_is_shown_with_question_marks() -> None:
    frame = np.frombuffer(EXAMPLES[2], counts.IDENTITY).copy()
    frame["model"] = b"A\x1b[2J\xff"
    assert counts.identify(frame.tobytes()).model == "A?[2J?"
