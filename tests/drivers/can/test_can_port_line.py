"""A CAN port with a serial adapter: when it asks it, what it makes of the answer and of bytes without a frame."""

import os
from collections.abc import Iterator

import can
import pytest
import serial

from drivers.can import can_port, frame_record
from drivers.can.can_port import CanPort
from drivers.can.frame_record import ERROR
from drivers.can.slcan_line import SlcanLine
from drivers.errors import LinkLost

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


@pytest.mark.usefixtures("never_silent")
def test_an_adapter_is_not_asked_as_soon_as_nothing_comes(ends: Ends) -> None:
    assert ends.read() == []
    assert ends.asked() == b""


def test_a_silent_adapter_is_asked_once(ends: Ends, silent: pytest.MonkeyPatch) -> None:
    assert ends.read() == ends.read() == []
    assert ends.asked() == QUESTION


def test_one_that_does_not_answer_in_time_is_a_lost_link(ends: Ends, silent: pytest.MonkeyPatch) -> None:
    ends.read()
    silent.setattr(can_port, "ANSWER_S", -1.0)
    with pytest.raises(LinkLost, match=r"the adapter no longer answers; unplug it and plug it in again"):
        ends.read()


def test_one_that_answers_is_asked_anew_at_the_next_silence(ends: Ends, silent: pytest.MonkeyPatch) -> None:
    ends.line.took(b"zz")  # of before: no answer
    ends.read()
    assert ends.asked() == QUESTION
    ends.line.took(b"V1013\r")
    assert ends.read() == []
    assert ends.asked() == b""
    assert ends.read() == []
    assert ends.asked() == QUESTION
    silent.setattr(can_port, "ANSWER_S", -1.0)
    with pytest.raises(LinkLost, match="no longer answers"):
        ends.read()


def test_one_that_says_bus_off_is_a_lost_link(ends: Ends, silent: pytest.MonkeyPatch) -> None:
    ends.read()
    ends.line.took(b"V1013\rF80\r")
    with pytest.raises(LinkLost, match="bus-off"):
        ends.read()


def test_a_frame_is_as_good_as_an_answer(ends: Ends, silent: pytest.MonkeyPatch) -> None:
    ends.read()
    assert ends.asked() == QUESTION
    ends.line.took(b"t0010\r")
    ends.bus.given.append(can.Message(arbitration_id=1, is_extended_id=False))
    assert ends.read() == [(1, b"")]
    ends.read()
    assert ends.asked() == QUESTION


@pytest.mark.usefixtures("never_silent")
def test_sixty_four_bytes_without_a_frame_are_an_error(ends: Ends) -> None:
    ends.line.took(63 * b"x")
    assert ends.read() == []
    ends.line.took(b"x")
    assert ends.read() == [(ERROR, b"")]
    assert ends.read() == []
    ends.line.took(64 * b"x")
    assert ends.read() == [(ERROR, b"")]


@pytest.mark.usefixtures("never_silent")
def test_bytes_are_counted_from_the_last_frame(ends: Ends) -> None:
    ends.line.took(63 * b"x")
    ends.bus.given.append(can.Message(arbitration_id=1, is_extended_id=False))
    assert ends.read() == [(1, b"")]
    ends.line.took(63 * b"x")
    assert ends.read() == []
    ends.line.took(b"x")
    assert ends.read() == [(ERROR, b"")]


def test_bytes_are_counted_from_the_last_answer(ends: Ends, silent: pytest.MonkeyPatch) -> None:
    ends.line.took(40 * b"x")
    ends.read()
    ends.line.took(b"V1013\r")
    assert ends.read() == []
    ends.line.took(63 * b"x")
    assert ends.read() == []
    ends.line.took(b"x")
    assert ends.read() == [(ERROR, b"")]


def test_an_adapter_that_is_closed_is_a_lost_link(ends: Ends) -> None:
    ends.port.close()
    with pytest.raises(LinkLost):
        ends.read()
