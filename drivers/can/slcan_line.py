"""What python-can's slcan reads from instead of the serial line: whole reads, and the adapter's own state.

slcan asks for a byte at a time, which at 3000 frames/s is 66000 system calls a second; it reads none of the
adapter's answers; and one octet that is no ASCII stops it for good. This stands in between: it reads what is there
at once, turns such octets into question marks, and watches for the answers to `V` and `F`.

Source: LAWICEL CAN232 manual: V version, F status flags, answers end in CR, BEL says that a command was refused.
"""

import re
import select

import can
import serial

ASCII = bytes(octet if octet < 0x80 else 0x3F for octet in range(256))
FLAGS = re.compile(rb"(?<=[\r\a])F([0-9A-Fa-f]{2})\r")  # behind the end of another: a frame's data may be F20, too
REMEDY = "check bit rate, wiring and termination"
PASSIVE, BUS_ERROR = 0x20, 0x80  # too many errors to take part in the bus


class SlcanLine:
    """A serial line with an adapter behind it; ``flags`` is the status it last told, None while it has not."""

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
        if told := FLAGS.findall(self._tail + data):
            self.flags = int(told[-1], 16)
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
