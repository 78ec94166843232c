"""A CAN port on a bus that gives the frames of a list: how each is recorded, and what ends the link."""

import errno
from typing import Any

import can
import pytest
from can.interfaces import BACKENDS

from drivers.can import frame_record
from drivers.can.can_port import CanPort, open_can
from drivers.can.frame_record import ERROR, EXTENDED, REMOTE
from drivers.errors import PortBusy, PortDenied, PortNotFound
from procedures.errors import ErrorCode
from tests.refusals import refused

OPENED = list[dict[str, Any]]()


class Given(can.BusABC):
    """Gives one after another; raises those that are errors."""

    def __init__(self, channel: str = "x", *given: can.Message | Exception, **options: Any) -> None:
        super().__init__(channel=channel)
        self.given, self.ails, self.waited = list(given), can.BusState.ACTIVE, list[float | None]()

    @property
    def state(self) -> can.BusState:
        return self.ails

    @state.setter
    def state(self, new: can.BusState) -> None:
        self.ails = new

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        self.waited.append(timeout)
        one = self.given.pop(0) if self.given else None
        if isinstance(one, Exception):
            raise one
        return one, False

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        raise NotImplementedError


class Opened(Given):
    """Stands for one of python-can's interfaces, with options of its own."""

    def __init__(
        self, channel: str, bitrate: int = 0, name: str = "", listens: bool = False, **kwargs: Any
    ) -> None:
        super().__init__(channel)
        OPENED.append({"channel": channel, "bitrate": bitrate, "name": name, "listens": listens})
        if isinstance(error := FAILS.get(channel), Exception):
            raise error


def caused(cause: Exception, *, is_context: bool = False) -> Exception:
    error = can.CanInitializationError("no")
    if is_context:
        error.__context__ = cause
    else:
        error.__cause__ = cause
    return error


FAILS: dict[str, Exception] = {
    "denied": PermissionError(errno.EACCES, "no"),
    "forbidden": OSError(errno.EPERM, "no"),
    "busy": OSError(errno.EBUSY, "no"),
    "again": OSError(errno.EAGAIN, "no"),
    "absent": OSError(errno.ENODEV, "nothing there"),
    "cause": caused(OSError(errno.EBUSY, "no")),
    "context": caused(OSError(errno.EACCES, "no"), is_context=True),
    "/dev/busy": OSError(errno.EBUSY, "no"),
    "odd": KeyError("strange"),
}


@pytest.fixture(autouse=True)
def interfaces(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(BACKENDS, "vector", (__name__, "Opened"))
    monkeypatch.setitem(BACKENDS, "pcan", ("there_is_no_such_module", "Bus"))
    OPENED.clear()


def plain(identifier: int, data: bytes = b"", **flags: Any) -> can.Message:
    return can.Message(arbitration_id=identifier, data=data, check=False, **{"is_extended_id": False, **flags})


def read(*given: can.Message | Exception, most: int = 65536) -> list[tuple[int, bytes]]:
    return frame_record.unpack(CanPort(Given("x", *given), "x", 0.0).read(most))


@pytest.mark.parametrize(
    ("message", "identifier", "data"),
    [
        (plain(0, b"\x01"), 0, b"\x01"),
        (plain(0x7FF, b"12345678"), 0x7FF, b"12345678"),
        (plain(0x7FF, is_extended_id=True), EXTENDED | 0x7FF, b""),
        (plain(0x1FFFFFFF, b"ab", is_extended_id=True), EXTENDED | 0x1FFFFFFF, b"ab"),
        (plain(0x123, is_remote_frame=True), REMOTE | 0x123, b""),
        (plain(0x20, bytes(8), is_error_frame=True), ERROR | 0x20, bytes(8)),
        (plain(0x80, bytes(8), is_error_frame=True), ERROR | 0x80, bytes(8)),
        (plain(0x40, b"\x09"), 0x40, b"\x09"),
    ],
)
def test_a_frame_is_recorded_with_its_identifier_flags_and_data(
    message: can.Message, identifier: int, data: bytes
) -> None:
    assert read(message) == [(identifier, data)]


@pytest.mark.parametrize(
    "given",
    [
        plain(0x800), plain(-0x1A), plain(0x20000000, is_extended_id=True), plain(-1, is_extended_id=True),
        ValueError("no number"), IndexError("too short"),
    ],
)  # fmt: skip
def test_what_is_no_frame_is_an_error_record_and_what_follows_is_read(given: can.Message | Exception) -> None:
    assert read(given, plain(5, b"z")) == [(ERROR, b""), (5, b"z")]


@pytest.mark.parametrize(
    ("kind", "channels"),
    [
        (PortDenied, ("denied", "forbidden", "context")), (PortBusy, ("busy", "again", "cause")),
        (PortNotFound, ("absent", "odd")),
    ],
)  # fmt: skip
def test_why_a_bus_does_not_open_is_reported(kind: type[Exception], channels: tuple[str, ...]) -> None:
    for channel in channels:
        with refused(kind, ErrorCode.DEVICE, channel):
            open_can("vector", channel, {}, 0.0)
