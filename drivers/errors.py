"""What a device, its link, its address or the simulator can refuse, and why in one clause (`reason_of`).

DriverError                            caught where a device is opened or read; the station says it in one line
├── BadDeviceUrl (ValueError)          the address cannot be read
├── BadCanFile (ValueError)            a DBC, a mapping file or a CAN log breaks a rule
├── PortNotFound (FileNotFoundError)   there is no such port, or nothing listens there
├── PortBusy                           another program holds the port
├── PortDenied (PermissionError)       the user may not open the port
├── LinkSilent (TimeoutError)          the port is open, no byte arrives
├── WrongFormat                        bytes arrive, no frame is among them
├── DeadChannel                        a channel sends one value though it could not
├── LinkLost (ConnectionError)         the port went away while open
└── ReplayEnded (EOFError)             a replayed file is at its end

SimulatorError                         raised by `drivers.simulated` alone
├── TruthRefused (ValueError)          a truth file or table breaks a rule
├── UnknownEffect (ValueError)         an effect or one of its coefficients has no such name
└── ControlRefused (OSError)           a simulated device refused a command
    └── ControlUnreachable             its control port does not answer
"""

import os
import re
from collections.abc import Iterable

from procedures.errors import ErrorCode


class DriverError(Exception):
    """The base of all that a device, its link or its address refuses.

    The text is one line: what was found, what was expected, what to do.
    """

    code = ErrorCode.DEVICE


class BadDeviceUrl(DriverError, ValueError):
    """A device's address cannot be read; ``expected`` says what would be accepted.

    Example: ``serial:///dev/ttyUSB0?bud=115200``, an option that there is not.
    """

    code = ErrorCode.DEVICE_ADDRESS

    def __init__(self, url: str, found: str, expected: str) -> None:
        self.url, self.found, self.expected = url, found, expected
        super().__init__(f"device {url!r}: {found}; expected {expected}")


class BadCanFile(DriverError, ValueError):
    """A DBC, a mapping file or a CAN log breaks a rule; ``line`` is None where no line can be named.

    Example: the mapping names a signal that the DBC does not have, or a log was recorded without times.
    """

    code = ErrorCode.CAN_FILE

    def __init__(self, path: str, line: int | None, found: str, expected: str) -> None:
        self.path, self.line, self.found, self.expected = path, line, found, expected
        where = path if line is None else f"{path}, line {line}"
        super().__init__(f"{where}: found {found}; expected {expected}")


class PortNotFound(DriverError, FileNotFoundError):
    """There is no such port, or nothing listens there; ``advice`` says what to check.

    Example: the USB adapter is not plugged in, the device server is off, or ``/dev/video0`` is no camera.
    """

    def __init__(self, port: str, reason: str, advice: str) -> None:
        self.port, self.reason, self.advice = port, reason, advice
        super().__init__(f"{port}: {reason}, expected a device there; {advice}")


class PortBusy(DriverError):
    """Another program holds the port.

    Example: a terminal program or a second `station stream` has the same serial line open.
    """

    def __init__(self, port: str, or_else: str = "") -> None:
        self.port = port
        super().__init__(
            f"{port} is open in another program, expected it free; close that program (`fuser {port}` names it)"
            + or_else
        )


class PortDenied(DriverError, PermissionError):
    """The user may not open the port.

    Example: a new account that is not in the group ``dialout``.
    """

    def __init__(self, port: str) -> None:
        self.port = port
        super().__init__(
            f"{port}: permission denied, expected read and write; add yourself to the group that owns it "
            f"(`sudo usermod -aG dialout $USER`, then log in again)"
        )


class LinkSilent(DriverError, TimeoutError):
    """No byte arrived before the deadline; ``baud`` is None where the link has none.

    Example: the device has no power, or its transmit and receive wires are swapped.
    """

    def __init__(
        self,
        port: str,
        waited_s: float,
        baud: int | None = None,
        advice: str = "check its power, that it is set to send, and that its two signal wires are not swapped",
    ) -> None:
        self.port, self.waited_s, self.baud = port, waited_s, baud
        at = "" if baud is None else f" at {baud} baud"
        super().__init__(f"{port}: no bytes for {waited_s:.1f} s{at}, expected a stream; {advice}")


class WrongFormat(DriverError):
    """Bytes arrive but no frame of the expected format, of any known one where that is empty.

    ``likely`` names the format they look like, if any; ``seen`` says what was among them instead, if known.

    Example: the address says ``format=counts`` and the device sends STIM300 datagrams, or the baud rate is wrong.
    """

    def __init__(
        self,
        port: str,
        format_name: str,
        bytes_seen: int,
        baud: int | None = None,
        likely: str | None = None,
        seen: str = "",
    ) -> None:
        self.port, self.format_name, self.bytes_seen = port, format_name, bytes_seen
        self.baud, self.likely, self.seen = baud, likely, seen
        at = "" if baud is None else f" at {baud} baud"
        advice = (
            f"they look like {likely}: say format={likely}" if likely else seen or "check baud rate and format"
        )
        none = f"hold no {format_name} frame" if format_name else "hold no frame of any known format"
        super().__init__(f"{port}: {bytes_seen} bytes{at} {none}; {advice}")


class LinkLost(DriverError, ConnectionError):
    """The port went away while it was open.

    Example: the cable was pulled, the device was switched off, or the other side closed the connection.
    """

    def __init__(self, port: str, reason: str) -> None:
        self.port, self.reason = port, reason
        super().__init__(f"{port} was lost ({reason}), expected it to stay open; check cable and power")


class DeadChannel(DriverError):
    """A channel sends one value though it could not; ``reason`` names it and says what to do.

    Example: gyro x sends 0 while the others change: its wire is broken, or the mapping names the wrong signal.
    """

    def __init__(self, port: str, reason: str) -> None:
        self.port, self.reason = port, reason
        super().__init__(f"{port}: {reason}")


class ReplayEnded(DriverError, EOFError):
    """A replayed file is at its end: not a fault, but nothing more will come.

    Example: `station stream replay:session.bin` has sent its last byte.
    """

    def __init__(self, path: str, size: int) -> None:
        self.path, self.size = path, size
        super().__init__(f"replay of {path} is at its end after {size} bytes")


class SimulatorError(Exception):
    """The base of all that ``drivers.simulated`` refuses."""


class TruthRefused(SimulatorError, ValueError):
    """A truth breaks a rule; says what was found and what is accepted.

    Example: a truth file with ``gyro_k`` of two numbers instead of three.
    """

    def __init__(self, found: str, expected: str) -> None:
        self.found, self.expected = found, expected
        super().__init__(f"simulator truth: found {found}; expected {expected}")


class UnknownEffect(SimulatorError, ValueError):
    """An effect or coefficient has no such name; lists the names there are.

    Example: ``--effect gyroscope.g_sensitivty.x=0.1``, a slip of the pen.
    """

    def __init__(self, name: str, accepted: Iterable[str]) -> None:
        self.name, self.accepted = name, tuple(accepted)
        super().__init__(f"no simulated effect {name!r}; expected one of {', '.join(self.accepted)}")


class ControlRefused(SimulatorError, OSError):
    """A simulated device answered a command with ``error``.

    Example: position 25 of a cube that has 24.
    """

    def __init__(self, address: str, command: str, answer: str) -> None:
        self.address, self.command, self.answer = address, command, answer
        super().__init__(
            f"{address}: {command!r} found {answer!r}, expected an answer `ok ...`; check that `station simulate` "
            "runs and that --hands is the control address that it prints"
        )


class ControlUnreachable(ControlRefused):
    """A simulated device does not answer; it may have been started again and answer later.

    Example: `station simulate` was ended while a guided calibration moved its cube.
    """


_NUMBERED = re.compile(r"\[Errno -?\d+\] ([^:\[\]'\"]+)|\(-?\d+, '([^']+)'\)")
_MEANINGS = {  # what libraries say in words of their own
    "returned no data": "it sends nothing any more: unplugged, or another program reads it too",
    "port that is not open": "it is closed",
}


def reason_of(error: BaseException) -> str:
    """Return one short clause: no numbers, no name of what failed, nothing twice."""
    text = " ".join(str(error).split())
    for wording, meant in _MEANINGS.items():
        if wording in text:
            return meant
    if numbered := _NUMBERED.findall(text):
        return str(next(filter(None, numbered[-1]))).strip()
    code = getattr(error, "errno", None)
    if isinstance(code, int) and code > 0:
        return os.strerror(code)
    return getattr(error, "strerror", None) or text or type(error).__name__
