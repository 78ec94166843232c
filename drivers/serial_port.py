"""A serial line, real or pty: the only file that knows pyserial."""

import contextlib
import errno
import os
import termios
from dataclasses import dataclass

import serial
from serial.tools import list_ports as serial_list_ports

from drivers.error_reason import reason_of
from drivers.errors import BadDeviceUrl, DriverError, LinkLost, PortBusy, PortDenied, PortNotFound
from drivers.latency_timer import latency_ms, shorten_latency

WRITE_TIMEOUT_S = 1.0
PTYS = "/dev/pts/"
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
        raise BadDeviceUrl(
            device, f"baud {baud} ({reason_of(error)})", "a rate that this adapter can do"
        ) from error
    # FTDI adapters hold bytes back for 16 ms otherwise (pyserial issue 287); ptys cannot and need not.
    with contextlib.suppress(ValueError, NotImplementedError):
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
