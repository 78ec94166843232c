"""A serial CAN adapter: when it is asked, what its answers and bytes without a frame mean, damaged text."""

import os
from collections.abc import Iterator

import can
import pytest
import serial

from drivers.can import can_port, frame_record
from drivers.can.can_port import CanPort, SlcanLine
from drivers.can.frame_record import ERROR
from drivers.errors import LinkLost
from tests.benchmarks.hostile_slcan import attack

ALL = 65536
QUESTION = b"V\rF\r"


class Bus(can.BusABC):
    """Gives the frames of a list; takes no bytes from the line."""

    def __init__(self) -> None:
        super().__init__(channel="x")
        self.given = list[can.Message]()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        return (self.given.pop(0) if self.given else None), False

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        raise NotImplementedError


class Ends:
    """The port, its bus and its line, and what has come to the adapter."""

    def __init__(self, line: SlcanLine, adapter: int) -> None:
        self.line, self.bus, self.adapter = line, Bus(), adapter
        self.port = CanPort(self.bus, "x", 0.0, line)

    def read(self) -> list[tuple[int, bytes]]:
        return frame_record.unpack(self.port.read(ALL))

    def asked(self) -> bytes:
        try:
            return os.read(self.adapter, 64).replace(b"\n", b"\r")
        except BlockingIOError:
            return b""


@pytest.fixture
def ends() -> Iterator[Ends]:
    ours, theirs = os.openpty()
    os.set_blocking(ours, False)
    port = serial.Serial(os.ttyname(theirs), timeout=0)
    both = Ends(SlcanLine(port), ours)
    yield both
    both.port.close()
    for descriptor in (ours, theirs):
        os.close(descriptor)


@pytest.fixture
def silent(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """Have every read without a frame be a silence, and an adapter have all the time to answer."""
    monkeypatch.setattr(can_port, "SILENT_S", -1.0)
    monkeypatch.setattr(can_port, "ANSWER_S", 1e9)
    return monkeypatch


@pytest.fixture
def never_silent(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have no silence, however long this process waits for a processor."""
    monkeypatch.setattr(can_port, "SILENT_S", 1e9)


def test_one_that_does_not_answer_in_time_is_a_lost_link(ends: Ends, silent: pytest.MonkeyPatch) -> None:
    ends.read()
    silent.setattr(can_port, "ANSWER_S", -1.0)
    with pytest.raises(LinkLost):
        ends.read()


def test_one_that_answers_is_asked_again_at_the_next_silence(ends: Ends, silent: pytest.MonkeyPatch) -> None:
    ends.line.took(b"zz")  # of before: no answer
    ends.read()
    assert ends.asked() == QUESTION
    ends.line.took(b"V1013\r")
    assert ends.read() == []
    assert ends.asked() == b""
    assert ends.read() == []
    assert ends.asked() == QUESTION
    silent.setattr(can_port, "ANSWER_S", -1.0)
    with pytest.raises(LinkLost):
        ends.read()


@pytest.mark.usefixtures("never_silent")
def test_sixty_four_bytes_without_a_frame_are_an_error(ends: Ends) -> None:
    ends.line.took(63 * b"x")
    assert ends.read() == []
    ends.line.took(b"x")
    assert ends.read() == [(ERROR, b"")]
    assert ends.read() == []
    ends.line.took(64 * b"x")
    assert ends.read() == [(ERROR, b"")]


@pytest.fixture
def line_ends() -> Iterator[tuple[SlcanLine, int]]:
    """The line, and the adapter's end of it."""
    ours, theirs = os.openpty()
    with serial.Serial(os.ttyname(theirs), timeout=0) as port:
        yield SlcanLine(port), ours
    os.close(ours)
    os.close(theirs)


def test_bytes_are_handed_on_in_order_and_once(line_ends: tuple[SlcanLine, int]) -> None:
    line, adapter = line_ends
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


@pytest.mark.parametrize(("flags", "reported"), [(0x20, "error passive"), (0x80, "bus-off"), (0xA0, "bus-off")])
def test_a_bus_in_trouble_is_reported(flags: int, reported: str) -> None:
    line = SlcanLine(serial.Serial())
    for harmless in (None, 0, 0x5F):  # a full queue, a lost frame, an arbitration lost
        line.flags = harmless
        line.refuse_trouble()
    line.flags = flags
    with pytest.raises(can.CanOperationError, match=reported):
        line.refuse_trouble()


def test_damaged_text_never_crashes_and_hardly_passes() -> None:
    got = attack(6000, seed=3)
    assert got.crashes == 0
    assert got.checks_failed > 1000, "too few were damaged in what the check is for"
    assert 0 < got.wrong <= 2 * got.expected, "some pass eight bits, no more than chance lets"
    assert got.wrong_samples <= 3, "20 in a million lines"
    assert got.samples > 20
