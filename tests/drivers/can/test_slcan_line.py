"""Octets of an adapter by LAWICEL's manual, cut as they may come."""

import os
import time
from collections.abc import Iterator

import can
import pytest
import serial

from drivers.can.slcan_line import SlcanLine
from tests.patience import HANG_S


@pytest.fixture
def ends() -> Iterator[tuple[SlcanLine, int]]:
    """The line, and the adapter's end of it."""
    ours, theirs = os.openpty()
    with serial.Serial(os.ttyname(theirs), timeout=0) as port:
        yield SlcanLine(port), ours
    os.close(ours)
    os.close(theirs)


def test_bytes_are_handed_on_in_order_and_once(ends: tuple[SlcanLine, int]) -> None:
    line, adapter = ends
    assert (line.in_waiting, line.received, line.flags, line.read(9)) == (0, 0, None, b"")
    assert not line.fill(0.0)
    os.write(adapter, b"t1232AABB\r")
    assert line.fill(5.0)
    while line.in_waiting < 10:
        line.fill(5.0)
    assert (line.read(4), line.in_waiting, line.read()) == (b"t123", 6, b"2")
    assert line.took(b"xyz")
    assert (line.in_waiting, line.read(20), line.in_waiting, line.read(1)) == (8, b"AABB\rxyz", 0, b"")
    assert line.received == 13
    assert not line.took(b"")


def test_an_octet_that_is_no_ascii_is_a_question_mark() -> None:
    line = SlcanLine(serial.Serial())
    line.took(b"a\x7f\x80\xffb")
    assert line.read(9) == b"a\x7f??b"


@pytest.mark.parametrize(
    ("parts", "flags"),
    [
        ([b"\rF04\r"], 0x04), ([b"F20\r"], None),
        ([b"V1013\rF", b"A", b"0\r"], 0xA0), ([b"t1231F0\r"], None), ([b"\aF20\r"], 0x20),
        ([b"F0", b"4"], None), ([b"t12313\rF", b"f1\rt1231"], 0xF1),
        ([b"t1232AF20\r", b"V1013\r"], None), ([b"t1232AF20\r", b"V1013\rF00\r"], 0x00), ([b"\rF20\rF00\r"], 0x00),
        ([b"t1232AF20\r", b"\r"], None),
    ],
)  # fmt: skip
def test_the_status_is_read_wherever_the_stream_is_cut(parts: list[bytes], flags: int | None) -> None:
    line = SlcanLine(serial.Serial())
    for part in parts:
        line.took(part)
    assert line.flags == flags


def test_version_and_status_are_asked_for_and_the_old_status_is_forgotten(ends: tuple[SlcanLine, int]) -> None:
    line, adapter = ends
    line.took(b"\rF20\r")
    line.ask()
    assert line.flags is None
    heard, until = b"", time.monotonic() + HANG_S
    while len(heard) < 4 and time.monotonic() < until:
        heard += os.read(adapter, 16)
    assert heard.replace(b"\n", b"\r") == b"V\rF\r"


@pytest.mark.parametrize(("flags", "said"), [(0x20, "error passive"), (0x80, "bus-off"), (0xA0, "bus-off")])
def test_a_bus_in_trouble_is_told(flags: int, said: str) -> None:
    line = SlcanLine(serial.Serial())
    for harmless in (None, 0, 0x5F):  # a full queue, a lost frame, an arbitration lost
        line.flags = harmless
        line.refuse_trouble()
    line.flags = flags
    with pytest.raises(can.CanOperationError, match=f"{said}; check bit rate"):
        line.refuse_trouble()


def test_the_newest_status_stands_whatever_came_in_between() -> None:
    line = SlcanLine(serial.Serial())
    line.took(b"F20\r")
    line.took(b"t1230\r")
    line.took(b"V1013\rF00\r")
    assert line.flags == 0
    line.took(b"zzz\r")
    assert line.flags == 0


@pytest.mark.parametrize("cut", range(1, 5))
def test_an_answer_is_known_in_whatever_two_parts_it_comes(cut: int) -> None:
    line, answer = SlcanLine(serial.Serial()), b"\rFA4\r"
    line.took(b"t12321122" + answer[:cut])
    line.took(answer[cut:])
    assert line.flags == 0xA4


@pytest.mark.parametrize("said", [b"F2G\r", b"F2\r", b"F200\r", b"xF20\r", b"f20\r"])
def test_what_is_no_status_changes_none(said: bytes) -> None:
    line = SlcanLine(serial.Serial())
    line.took(said)
    assert line.flags is None


def test_what_the_line_is_told_goes_to_the_adapter(ends: tuple[SlcanLine, int]) -> None:
    line, adapter = ends
    line.write(b"O")
    line.flush()
    assert os.read(adapter, 16) == b"O"
    line.close()
    with pytest.raises(serial.PortNotOpenError):
        line.write(b"C")
