"""A serial line, real or pty: the only file that knows pyserial. Baud and parity come with `drivers.addresses`."""

import contextlib
import errno
import os
import termios
from dataclasses import dataclass
from pathlib import Path

import serial
from serial.tools import list_ports as serial_list_ports

from drivers.errors import BadDeviceUrl, DriverError, LinkLost, PortBusy, PortDenied, PortNotFound, reason_of

WRITE_TIMEOUT_S = 1.0
PTYS = "/dev/pts/"
TTYS = Path("/sys/class/tty")
# A USB adapter holds bytes back for 16 ms before it sends a packet that is not full: at 100 Hz frames come up to
# 30 ms late, in clumps (pyserial issue 287; a KVH 1750 driver sets the same file). The serial line's low-latency
# flag asks the kernel for the same, but not every kernel's driver heeds it.
WANTED_LATENCY_MS = 1
# pyserial lets some of the operating system's own errors through: EIO of an unplugged port, termios.error.
LINK_ERRORS = (serial.SerialException, OSError, termios.error)


class SerialPort:
    """An open serial line, 8 data bits, 1 stop bit, no flow control, held for this program alone."""

    def __init__(self, line: serial.Serial, device: str) -> None:
        self.device = device
        self._serial = line

    def read(self, max_bytes: int) -> bytes:
        """Return what has come, empty after the timeout; read(max_bytes) would wait for all of it."""
        try:
            first: bytes = self._serial.read(1)
            more = min(self._serial.in_waiting, max_bytes - 1) if first else 0
            return first + self._serial.read(more) if more else first
        except LINK_ERRORS as error:
            raise LinkLost(self.device, reason_of(error)) from error

    def fileno(self) -> int:
        """Return what `select` takes."""
        number: int = self._serial.fileno()
        return number

    def write(self, data: bytes) -> None:
        """Send ``data`` whole."""
        try:
            self._serial.write(data)
        except LINK_ERRORS as error:
            raise LinkLost(self.device, reason_of(error)) from error

    def close(self) -> None:
        """Give the line back."""
        with contextlib.suppress(*LINK_ERRORS):
            self._serial.close()


def latency_ms(device: str, ttys: Path = TTYS) -> int | None:
    """Return the adapter's latency timer [ms]; None where the port has none."""
    try:
        return int(_latency_file(device, ttys).read_text(encoding="ascii"))
    except (OSError, ValueError):
        return None


def shorten_latency(device: str, ttys: Path = TTYS) -> int | None:
    """Set the latency timer to 1 ms, where the port has one and it may be set; return what holds now [ms]."""
    before = latency_ms(device, ttys)
    if before is not None and before > WANTED_LATENCY_MS:
        with contextlib.suppress(OSError):  # root alone may, unless a udev rule says otherwise
            _latency_file(device, ttys).write_text(f"{WANTED_LATENCY_MS}", encoding="ascii")
    return latency_ms(device, ttys)


def _latency_file(device: str, ttys: Path) -> Path:
    return ttys / Path(os.path.realpath(device)).name / "device/latency_timer"


def open_serial(device: str, baud: int, parity: str, timeout_s: float) -> SerialPort:
    """Open a serial line; raise `PortNotFound`, `PortBusy`, `PortDenied` or, for the baud rate, `BadDeviceUrl`."""
    if os.path.realpath(device).startswith(PTYS):  # no line, so no parity: asked for one it says EINVAL
        parity = "N"
    try:
        line = serial.Serial(
            device, baud, parity=parity, timeout=timeout_s, write_timeout=WRITE_TIMEOUT_S, exclusive=True
        )
    except LINK_ERRORS as error:
        raise _refusal(device, error) from error
    except ValueError as error:
        found = f"baud {baud} ({reason_of(error)})"
        raise BadDeviceUrl(device, found, "a rate that this adapter can do") from error
    with contextlib.suppress(ValueError, NotImplementedError):  # ptys cannot and need not
        line.set_low_latency_mode(True)
    shorten_latency(device)
    return SerialPort(line, device)


@dataclass(frozen=True, slots=True)
class PortInfo:
    """A serial port of this machine: its device file, what the adapter says it is, the adapter's serial number.

    ``latency_ms`` is how long the adapter holds bytes back [ms], None where it has no such timer.
    """

    device: str
    description: str
    serial_number: str | None
    latency_ms: int | None = None


def list_ports() -> list[PortInfo]:
    """Return the serial ports present, by device name."""
    found = [
        PortInfo(port.device, port.description, port.serial_number, latency_ms(port.device))
        for port in serial_list_ports.comports()
    ]
    return sorted(found, key=lambda port: port.device)


def _refusal(device: str, error: Exception) -> DriverError:
    code = error.errno if isinstance(error, OSError) else None
    if code in (errno.EBUSY, errno.EAGAIN):
        return PortBusy(device)
    if code in (errno.EACCES, errno.EPERM):
        return PortDenied(device)
    names = ", ".join(port.device for port in list_ports())
    present = f"serial ports present: {names}" if names else "no serial port is present"
    if not os.path.exists(device):
        reason = "no such port"
    elif code == errno.ENOTTY or "Inappropriate ioctl" in str(error):
        reason = "no serial port but something else"
    else:
        reason = f"not usable as a serial port ({reason_of(error)})"
    return PortNotFound(device, reason, f"{present}; check the cable and the name")
