"""A CAN bus as a port of bytes: any interface of python-can, its frames as records.

Whatever python-can raises when a bus ends becomes `LinkLost`, and so do bus-off and an adapter that no longer
answers, which it does not report. Its slcan reads a byte at a time (66000 system calls a second at 3000 frames/s),
none of the adapter's answers, and stops for good at an octet that is no ASCII: `SlcanLine` reads for it. Source:
LAWICEL CAN232 manual: V version, F status flags, answers end in CR, BEL says that a command was refused.
"""

import contextlib
import errno
import inspect
import logging
import re
import select
import time
from collections.abc import Mapping
from importlib import import_module
from typing import Any

import can
import serial
from can.interfaces import BACKENDS
from can.interfaces.slcan import slcanBus

from drivers.can.frame_record import ERROR, EXTENDED, RECORD, REMOTE, STANDARD, WIDE, pack
from drivers.errors import BadDeviceUrl, DriverError, LinkLost, PortBusy, PortDenied, PortNotFound, reason_of

ASCII = bytes(octet if octet < 0x80 else 0x3F for octet in range(256))
FLAGS = re.compile(rb"(?<=[\r\a])F([0-9A-Fa-f]{2})\r")  # behind the end of another: a frame's data may be F20, too
REMEDY = "check bit rate, wiring and termination"
PASSIVE, BUS_ERROR = 0x20, 0x80  # too many errors to take part in the bus


class SlcanLine:
    """A serial line with an adapter behind it; ``flags`` is the status it last reported, None while it has not."""

    def __init__(self, line: serial.Serial) -> None:
        self._line = line
        self.write, self.flush, self.close = line.write, line.flush, line.close
        self._buffer, self._at = b"", 0
        self._tail = b""  # the end of what was looked through for answers
        self.flags: int | None = None
        self.received = 0  # bytes

    def fill(self, timeout_s: float) -> bool:
        """Wait for bytes and take all that have come; say whether any did."""
        if not select.select([self._line.fileno()], [], [], timeout_s)[0]:
            return False
        return self.took(self._line.read(max(1, self._line.in_waiting)))

    def took(self, data: bytes) -> bool:
        """Take bytes that have come; say whether there are any."""
        data = data.translate(ASCII)
        if reported := FLAGS.findall(self._tail + data):
            self.flags = int(reported[-1], 16)
        self._tail = (self._tail + data)[-4:]
        self.received += len(data)
        self._buffer, self._at = self._buffer[self._at :] + data, 0
        return bool(data)

    def ask(self) -> None:
        """Ask for version and status; an adapter that knows neither answers BEL."""
        self.flags = None
        self.write(b"V\rF\r")

    def refuse_trouble(self) -> None:
        """Raise `can.CanOperationError` where the status says that something is wrong with the bus."""
        if self.flags is not None and self.flags & (PASSIVE | BUS_ERROR):
            trouble = "bus-off" if self.flags & BUS_ERROR else "error passive"
            raise can.CanOperationError(f"the adapter says {trouble}; {REMEDY}")

    @property
    def in_waiting(self) -> int:
        """Bytes that were read and not yet asked for."""
        return len(self._buffer) - self._at

    def read(self, size: int = 1, /) -> bytes:
        """Return the next of the bytes in hand, none where there are none."""
        data = self._buffer[self._at : self._at + size]
        self._at += len(data)
        return data


OWN_ARGUMENTS = {"self", "channel", "kwargs", "interface", "can_filters"}
# python-can lets errors of what it stands on through
LINK_ERRORS = (can.CanError, OSError, RuntimeError)
GATHER_S = 0.003  # frames are handed on in handfuls: a decoder's cost is by the handful
SILENT_S = 0.5  # without a frame: ask the adapter
GARBLED_BYTES = 64  # bytes from an slcan adapter without a frame: more than it answers, so no lines of its own
ANSWER_S = 0.5  # how long it may take to answer
OPEN_ANSWER_S = 0.3
BUS_OFF = 0x40  # of an error frame's identifier (linux/can/error.h)
SLCAN = {"sleep_after_open": 0.1, "timeout": 0.05}  # python-can waits 2 s, for boards that restart when opened
SHARED = (
    "; for an IMU and a wheel on one adapter have the kernel share it: slcand -o -s8 {} slcan0, "
    "ip link set slcan0 up, and can://socketcan/slcan0 for both"
)

logging.getLogger("can").addHandler(logging.NullHandler())  # what is wrong is raised


class SlcanBus(slcanBus):
    """python-can's slcan bus, its ``tty`` read through ``line``."""

    def __init__(self, channel: str, options: Mapping[str, Any]) -> None:
        super().__init__(channel, **options)
        self.tty = self.serialPortOrig
        self.line = SlcanLine(self.tty)
        self.serialPortOrig = self.line  # type: ignore[assignment]  # which this class reads and writes


class CanPort:
    """An open bus; ``line`` is the serial line of an slcan adapter."""

    def __init__(self, bus: can.BusABC, name: str, timeout_s: float, line: SlcanLine | None = None) -> None:
        self.name = name
        self._bus, self._timeout_s, self._line = bus, timeout_s, line
        self._heard = time.monotonic()  # a frame, or an adapter in good order
        self._asked: tuple[float, int] | None = None  # when, and the bytes received by then
        self._made_out = 0  # bytes received by the last frame or answer

    def read(self, max_bytes: int) -> bytes:
        """Return records of the frames that have come; empty after the timeout."""
        try:
            records = self._gather(max(1, max_bytes // RECORD.itemsize))
            if not records and self._line and self._line.received - self._made_out >= GARBLED_BYTES:
                records = [pack(ERROR, time.monotonic_ns(), b"")]  # slcan passes over it and says nothing
            if records:
                self._heard, self._asked = time.monotonic(), None
                self._made_out = self._line.received if self._line is not None else 0
            elif time.monotonic() - self._heard > SILENT_S:
                self._ask(time.monotonic())
        except Exception as error:  # the same edge; the reader opens the port again
            raise LinkLost(self.name, reason_of(error)) from error
        return b"".join(records)

    def write(self, data: bytes) -> None:
        """Take ``data`` and drop it: the station only listens."""

    def close(self) -> None:
        """Leave the bus and give the adapter back."""
        with contextlib.suppress(*LINK_ERRORS):
            self._bus.shutdown()
        if self._line is not None:  # slcan leaves it open where the adapter is gone
            with contextlib.suppress(*LINK_ERRORS):
                self._line.close()

    def _gather(self, most: int) -> list[bytes]:
        records = list[bytes]()
        until = time.monotonic() + self._timeout_s
        while len(records) < most:
            left = max(0.0, until - time.monotonic())
            if self._line is not None and not self._line.in_waiting and not self._line.fill(left):
                break
            if record := self._frame(0.0 if self._line is not None else left):
                if not records:
                    until = min(until, time.monotonic() + GATHER_S)
                records.append(record)
            elif not left:
                break
        return records

    def _frame(self, timeout_s: float) -> bytes:
        try:
            message = self._bus.recv(timeout_s)
        except (ValueError, IndexError):  # slcan: a line that is no frame; to open the port again would lose more
            return pack(ERROR, time.monotonic_ns(), b"")
        if message is None:
            return b""
        if not 0 <= message.arbitration_id <= (WIDE if message.is_extended_id else STANDARD):
            return pack(ERROR, time.monotonic_ns(), b"")  # slcan reads -1A and FFFFFFFF too
        if message.is_error_frame and message.arbitration_id & BUS_OFF:
            raise can.CanOperationError(f"bus-off: too many errors; {REMEDY}")
        flags = EXTENDED * message.is_extended_id | REMOTE * message.is_remote_frame
        flags |= ERROR * message.is_error_frame
        return pack(message.arbitration_id | flags, time.monotonic_ns(), message.data)

    def _ask(self, now: float) -> None:
        """Find out who is silent: the devices, the bus or the adapter."""
        if getattr(self._bus, "state", None) is can.BusState.ERROR:
            raise can.CanOperationError(f"bus-off: too many errors; {REMEDY}")
        if self._line is None:
            return
        if self._asked is None:
            self._line.ask()
            self._asked = now, self._line.received
        elif self._line.received > self._asked[1]:
            self._line.refuse_trouble()
            self._heard, self._asked, self._made_out = now, None, self._line.received
        elif now - self._asked[0] > ANSWER_S:
            raise can.CanOperationError("the adapter no longer answers; unplug it and plug it in again")


def open_can(interface: str, channel: str, options: Mapping[str, str], timeout_s: float) -> CanPort:
    """Open a bus of any of python-can's interfaces.

    Raises `BadDeviceUrl` if there is no such interface, or it takes no such option. Raises `PortNotFound`,
    `PortBusy` or `PortDenied` if adapter or channel cannot be opened, or no slcan adapter answers. Raises
    `LinkLost` if it opens and is bus-off.
    """
    name = channel or interface
    chosen = {**(SLCAN if interface == "slcan" else {}), **_options(interface, channel, options)}
    try:
        bus: can.BusABC
        if interface == "slcan":
            bus = SlcanBus(channel, chosen)
        else:
            bus = can.Bus(channel=channel or None, interface=interface, **chosen)  # type: ignore[arg-type]
    except Exception as error:  # the edge to two dozen drivers, which raise what they like where theirs is missing
        raise _refusal(name, error) from error
    if not isinstance(bus, SlcanBus):
        return CanPort(bus, name, timeout_s)
    return _with_adapter(bus, name, timeout_s)


def _with_adapter(bus: SlcanBus, name: str, timeout_s: float) -> CanPort:
    """Return the port of a bus that was opened; raise where no adapter answers, or its bus is off."""
    line = bus.line
    port = CanPort(bus, name, timeout_s, line)
    try:
        bus.tty.exclusive = True
        line.ask()
        until = time.monotonic() + OPEN_ANSWER_S
        while line.flags is None:
            left = max(0.0, until - time.monotonic())
            if not line.fill(left) and not left:  # once more at the end: who was late may be this machine
                break
        if not line.received:
            raise PortNotFound(name, "no slcan adapter answers", "check cable, name and tty_baudrate")
        line.refuse_trouble()
    except LINK_ERRORS as error:
        port.close()
        if isinstance(error, DriverError):
            raise
        raise LinkLost(name, reason_of(error)) if line.received else _refusal(name, error) from error
    return port


def _options(interface: str, channel: str, options: Mapping[str, str]) -> dict[str, str | int | float | bool]:
    """Return options as python-can wants them; it would swallow those that it does not know."""
    url = f"can://{interface}/{channel.lstrip('/')}"
    if interface not in BACKENDS:
        raise BadDeviceUrl(url, f"interface {interface!r}", f"one of {', '.join(sorted(BACKENDS))}")
    module, name = BACKENDS[interface]
    try:
        backend = getattr(import_module(module), name)
    except ImportError as error:
        raise PortNotFound(interface, str(error), "install what this interface needs") from error
    accepted = [each for each in inspect.signature(backend.__init__).parameters if each not in OWN_ARGUMENTS]
    for option in options:
        if option not in accepted:
            raise BadDeviceUrl(url, f"option {option!r}", f"one of {', '.join(accepted)}")
    return {option: _value(text) for option, text in options.items()}


def _value(text: str) -> str | int | float | bool:
    if text.lower() in {"true", "false"}:
        return text.lower() == "true"
    for kind in (int, float):
        with contextlib.suppress(ValueError):
            return kind(text)
    return text


def _refusal(name: str, error: Exception) -> DriverError:
    reasons = [error, error.__cause__, error.__context__]
    codes = {each.errno for each in reasons if isinstance(each, OSError)}
    if codes & {errno.EACCES, errno.EPERM}:
        return PortDenied(name)
    if codes & {errno.EBUSY, errno.EAGAIN}:
        return PortBusy(name, SHARED.format(name) if "/" in name else "")  # a serial line: an slcan adapter
    return PortNotFound(
        name, f"no CAN bus ({reason_of(error)})", "check the adapter, its name, and what the interface needs"
    )
