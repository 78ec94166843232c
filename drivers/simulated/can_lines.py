"""Lines of a simulated device on CAN: an slcan adapter on a pty, and python-can's udp_multicast bus.

The adapter speaks as much of the LAWICEL protocol as a station can ask of it: S s O L C V N F and frames t T r R,
each line ended by CR; it answers CR, a value, z or Z, and BEL for what it does not understand or may not do now.
Source: LAWICEL CAN232 manual, 2.0.
"""

import contextlib
import os
import re
import select
from pathlib import Path
from threading import Condition, Event, Thread
from typing import TYPE_CHECKING

from drivers.can.frame_record import EXTENDED, IMU, RECORD, WIDE, unpack
from drivers.simulated.corrupted_frames import text_of_records
from drivers.simulated.serial_and_tcp_lines import STOP_CHECK_S, PtyLine

if TYPE_CHECKING:
    import can

MAX_WAITING_BYTES = 4096  # bytes for the station; a bus goes on, but what is simulated waits for its reader
GROUP, PORT = "239.74.163.2", 43113
ERROR, OK = b"\a", b"\r"
BIT_RATES = {b"S": re.compile(rb"[0-8]"), b"s": re.compile(rb"[0-9A-Fa-f]{4}")}
BUS_OFF_FLAGS = 0xA4  # error warning, error passive, bus error
FRAME = re.compile(
    rb"[tr][0-7][0-9A-Fa-f]{2}[0-8](?:[0-9A-Fa-f]{2})*|[TR][01][0-9A-Fa-f]{7}[0-8](?:[0-9A-Fa-f]{2})*"
)


class SlcanAdapter(PtyLine):
    """An slcan adapter; ``ails`` is what is wrong with it, such as ``adapter_hangs`` or ``bus_off``."""

    def __init__(self, link: Path | None = None) -> None:
        super().__init__(link)
        self.ails = ""
        self._is_open = False
        self._out = bytearray()
        self._room = Condition()
        self._gone = Event()
        self._thread: Thread | None = None

    @property
    def address(self) -> str:
        """The URL of the link, or of the terminal itself."""
        return super().address.replace("serial://", "can://slcan", 1)

    def plug(self) -> None:
        """Open a terminal; its adapter answers from now on."""
        super().plug()
        self._is_open = False
        self._gone.clear()
        self._out.clear()
        self._thread = Thread(target=self._serve, name="slcan adapter", daemon=True)
        self._thread.start()

    def unplug(self) -> None:
        """Take the adapter away."""
        self._gone.set()
        if self._thread is not None:
            self._thread.join()
        super().unplug()

    def write(self, data: bytes, stop: Event) -> bool:
        """Forward records, or noise on the line, to whoever opened the channel; waits while nobody has."""
        text = data
        if data.startswith(IMU.prefix) and len(data) % RECORD.itemsize == 0:
            text = text_of_records(data)
        for at in range(0, len(text), MAX_WAITING_BYTES):
            with self._room:
                while not self._has_room() and not stop.is_set() and not self._gone.is_set():
                    self._room.wait(STOP_CHECK_S)
                if stop.is_set() or self._gone.is_set():
                    return False
                self._out += text[at : at + MAX_WAITING_BYTES]
        return True

    def _has_room(self) -> bool:
        return self._is_open and len(self._out) < MAX_WAITING_BYTES

    def _serve(self) -> None:
        asked = b""
        while not self._gone.is_set():
            wants = [self._near] if self._out else []
            readable, writable, _ = select.select([self._near], wants, [], STOP_CHECK_S / 5)
            with self._room, contextlib.suppress(BlockingIOError):
                if readable:
                    *lines, asked = (asked + os.read(self._near, 4096)).split(b"\r")
                    if self.ails != "adapter_hangs":
                        for line in lines:
                            self._out += self._answer(line)
                if writable:
                    del self._out[: os.write(self._near, self._out)]
                self._room.notify_all()

    def _answer(self, line: bytes) -> bytes:
        """Return what the adapter says to a command."""
        word, rest, was_open = line[:1], line[1:], self._is_open
        match word:
            case b"":
                return OK
            case b"O" | b"L":
                self._is_open = True
                return ERROR if was_open else OK
            case b"C":
                self._is_open = False
                return OK if was_open else ERROR
            case b"S" | b"s" if not was_open and BIT_RATES[word].fullmatch(rest):
                return OK
            case b"V":
                return b"V1013\r"
            case b"N":
                return b"NFOG1\r"
            case b"F" if was_open:
                return b"F%02X\r" % (BUS_OFF_FLAGS if self.ails == "bus_off" else 0)
            case b"t" | b"r" | b"T" | b"R" if was_open and self.ails != "bus_off" and FRAME.fullmatch(line):
                return b"z\r" if word.islower() else b"Z\r"
        return ERROR


class UdpMulticastLine:
    """python-can's bus over UDP multicast; nothing leaves this machine, and nobody waits for a reader."""

    def __init__(self, port: int = 0) -> None:
        self._port = port or PORT
        self._bus: can.BusABC | None = None

    @property
    def address(self) -> str:
        """The URL of the bus."""
        return f"can://udp_multicast/{GROUP}"

    def plug(self) -> None:
        """Join the bus."""
        import can

        self._bus = can.Bus(interface="udp_multicast", channel=GROUP, port=self._port, hop_limit=0)

    def unplug(self) -> None:
        """Leave the bus."""
        if self._bus is not None:
            self._bus.shutdown()
        self._bus = None

    def write(self, data: bytes, stop: Event) -> bool:
        """Send the frames of records; noise has no place on this bus."""
        import can

        if self._bus is not None and data.startswith(IMU.prefix):
            for identifier, payload in unpack(data):
                is_wide = bool(identifier & EXTENDED)
                self._bus.send(can.Message(arbitration_id=identifier & WIDE, is_extended_id=is_wide, data=payload))
        return not stop.is_set()
