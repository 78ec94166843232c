"""What a device, its link or its address can refuse.

DriverError
├── BadDeviceUrl (ValueError)          the address cannot be read
├── BadCanFile (ValueError)            a DBC or a mapping file breaks a rule
├── PortNotFound (FileNotFoundError)   there is no such port, or nothing listens there
├── PortBusy                           another program holds the port
├── PortDenied (PermissionError)       the user may not open the port
├── LinkSilent (TimeoutError)          the port is open, no byte arrives
├── WrongFormat                        bytes arrive, no frame is among them
├── DeadChannel                        a channel puts out one value though it could not
├── LinkLost (ConnectionError)         the port went away while open
└── ReplayEnded (EOFError)             a replayed file is at its end
"""

import os
import re
from collections.abc import Iterable

from procedures.error_codes import ErrorCode


class DriverError(Exception):
    """The base of all that ``drivers`` raises on purpose; its text is one line: found, expected, what to do."""

    code = ErrorCode.DEVICE


class BadDeviceUrl(DriverError, ValueError):
    """A device's address cannot be read; ``expected`` says what would be accepted."""

    code = ErrorCode.DEVICE_ADDRESS

    def __init__(self, url: str, found: str, expected: str) -> None:
        self.url, self.found, self.expected = url, found, expected
        super().__init__(f"device {url!r}: {found}; expected {expected}")


class BadCanFile(DriverError, ValueError):
    """A DBC or a mapping file breaks a rule; ``line`` is None where no line can be named."""

    code = ErrorCode.CAN_FILE

    def __init__(self, path: str, line: int | None, found: str, expected: str) -> None:
        self.path, self.line, self.found, self.expected = path, line, found, expected
        where = path if line is None else f"{path}, line {line}"
        super().__init__(f"{where}: found {found}; expected {expected}")


class PortNotFound(DriverError, FileNotFoundError):
    """There is no such port, or nothing listens there; ``advice`` says what to check."""

    def __init__(self, port: str, reason: str, advice: str) -> None:
        self.port, self.reason, self.advice = port, reason, advice
        super().__init__(f"{port}: {reason}, expected a device there; {advice}")


class PortBusy(DriverError):
    """Another program holds the port."""

    def __init__(self, port: str, or_else: str = "") -> None:
        self.port = port
        super().__init__(
            f"{port} is open in another program, expected it free; close that program (`fuser {port}` names it)"
            + or_else
        )


class PortDenied(DriverError, PermissionError):
    """The user may not open the port."""

    def __init__(self, port: str) -> None:
        self.port = port
        super().__init__(
            f"{port}: permission denied, expected read and write; add yourself to the group that owns it "
            f"(`sudo usermod -aG dialout $USER`, then log in again)"
        )


class LinkSilent(DriverError, TimeoutError):
    """No byte arrived before the deadline; ``baud`` is None where the link has none."""

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

    ``likely`` names the format they look like, if any.

    ``seen`` says what was among them instead, if that is known.
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
    """The port went away while it was open: unplugged, powered off, or closed by the other side."""

    def __init__(self, port: str, reason: str) -> None:
        self.port, self.reason = port, reason
        super().__init__(f"{port} was lost ({reason}), expected it to stay open; check cable and power")


class DeadChannel(DriverError):
    """A channel puts out one value though it could not; ``said`` names it and says what to do."""

    def __init__(self, port: str, said: str) -> None:
        self.port, self.said = port, said
        super().__init__(f"{port}: {said}")


class ReplayEnded(DriverError, EOFError):
    """A replayed file is at its end."""

    def __init__(self, path: str, size: int) -> None:
        self.path, self.size = path, size
        super().__init__(f"replay of {path} is at its end after {size} bytes")


_NUMBERED = re.compile(r"\[Errno -?\d+\] ([^:\[\]'\"]+)|\(-?\d+, '([^']+)'\)")
_SAID = {  # what libraries say in words of their own
    "returned no data": "it sends nothing any more: unplugged, or another program reads it too",
    "port that is not open": "it is closed",
}


def reason_of(error: BaseException) -> str:
    """Return one short clause: no numbers, no name of what failed, nothing twice."""
    text = " ".join(str(error).split())
    for said, meant in _SAID.items():
        if said in text:
            return meant
    if numbered := _NUMBERED.findall(text):
        return str(next(filter(None, numbered[-1]))).strip()
    code = getattr(error, "errno", None)
    if isinstance(code, int) and code > 0:
        return os.strerror(code)
    return getattr(error, "strerror", None) or text or type(error).__name__


class SimulatorError(Exception):
    """The base of all that ``drivers.simulated`` raises on purpose."""


class TruthRefused(SimulatorError, ValueError):
    """A truth breaks a rule; says what was found and what is accepted."""

    def __init__(self, found: str, expected: str) -> None:
        self.found, self.expected = found, expected
        super().__init__(f"simulator truth: found {found}; expected {expected}")


class UnknownEffect(SimulatorError, ValueError):
    """An effect or coefficient has no such name; lists the names there are."""

    def __init__(self, name: str, accepted: Iterable[str]) -> None:
        self.name, self.accepted = name, tuple(accepted)
        super().__init__(f"no simulated effect {name!r}; expected one of {', '.join(self.accepted)}")


class ControlRefused(SimulatorError, OSError):
    """The simulated hands answered ``error`` or not at all."""

    def __init__(self, address: str, command: str, answer: str) -> None:
        self.address, self.command, self.answer = address, command, answer
        super().__init__(
            f"{address}: {command!r} found {answer!r}, expected an answer `ok ...`; check that `station simulate` "
            "runs and that --hands is the control address that it prints"
        )


class ControlUnreachable(ControlRefused):
    """The simulated hands do not answer; their device may have been started again and answer later."""
