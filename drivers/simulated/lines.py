"""The lines of simulated devices: pty, TCP and UDP; for CAN an slcan adapter on a pty, and a bus of python-can.

``write`` waits for room until it is stopped. Nothing blocks in ``exchange``; what finds no room is lost. The near
end of a pty stays open, so that a reader may come and go; closing it is what a reader sees as unplugged.
"""

import contextlib
import errno
import os
import re
import select
import socket
import tty
from pathlib import Path
from threading import Condition, Event, Thread
from typing import TYPE_CHECKING

from drivers.can.frame_record import EXTENDED, IMU, RECORD, WIDE, unpack
from drivers.simulated.corrupted_frames import text_of_records

if TYPE_CHECKING:
    import can

MAX_READ_BYTES = 65535
LOOPBACK = "127.0.0.1"
STOP_CHECK_S = 0.05  # how often a blocked write looks whether it should stop


class PtyLine:
    """A pseudo terminal, raw; ``link`` is a path that always points at it, also after an unplug."""

    def __init__(self, link: Path | None = None) -> None:
        self._link = link
        self._near = self._far = -1
        self._name = ""

    @property
    def address(self) -> str:
        """The URL of the link, or of the terminal itself."""
        return f"serial://{self._link.absolute() if self._link else self._name}"

    def plug(self) -> None:
        """Open a terminal and point the link at it; raise FileExistsError where the link is another file."""
        if self._link and self._link.exists() and not self._link.is_symlink():
            raise FileExistsError(errno.EEXIST, "exists and is not a link; choose another path", str(self._link))
        self._near, self._far = os.openpty()
        tty.setraw(self._far)
        os.set_blocking(self._near, False)
        self._name = os.ttyname(self._far)
        if self._link:
            self._link.unlink(missing_ok=True)
            self._link.symlink_to(self._name)

    def unplug(self) -> None:
        """Close the terminal: a blocked reader gets end of file."""
        if self._near < 0:
            return
        if self._link:
            self._link.unlink(missing_ok=True)
        os.close(self._near)
        os.close(self._far)
        self._near = self._far = -1

    def write(self, data: bytes, stop: Event) -> bool:
        """Send ``data`` whole, however long the reader takes; False if stopped. What a reader sends is dropped."""
        while data and not stop.is_set():
            readable, writable, _ = select.select([self._near], [self._near], [], STOP_CHECK_S)
            if readable:
                os.read(self._near, 4096)
            if writable:
                data = data[os.write(self._near, data) :]
        return not data

    def exchange(self, out: bytes, wait_s: float) -> bytes:
        """Send ``out``, wait at most ``wait_s`` for what comes, and return it."""
        with contextlib.suppress(BlockingIOError):
            os.write(self._near, out)
        if select.select([self._near], [], [], wait_s)[0]:
            return os.read(self._near, MAX_READ_BYTES)
        return b""


class TcpLine:
    """A listening port; one reader at a time, the device waits while there is none."""

    def __init__(self, host: str = LOOPBACK, port: int = 0) -> None:
        self._host, self._port = host, port
        self._listener: socket.socket | None = None
        self._reader: socket.socket | None = None

    @property
    def address(self) -> str:
        """The URL of the listening port."""
        return f"tcp://{self._host}:{self._port}"

    def plug(self) -> None:
        """Listen; the same port again after an unplug."""
        self._listener = socket.create_server((self._host, self._port))
        self._port = self._listener.getsockname()[1]

    def unplug(self) -> None:
        """Hang up and stop listening."""
        if self._listener is not None:  # first: whom we hang up on may call again at once
            self._listener.close()
            self._listener = None
        self._hang_up()

    def write(self, data: bytes, stop: Event) -> bool:
        """Send ``data`` whole, to whoever reads; False where the reader left before it had all of it."""
        while data and not stop.is_set():
            reader = self._reader or self._accepted()
            if reader is None:
                continue
            readable, writable, _ = select.select([reader], [reader], [], STOP_CHECK_S)
            try:
                if readable and not reader.recv(4096):
                    raise ConnectionResetError
                if writable:
                    data = data[reader.send(data) :]
            except BlockingIOError:
                continue
            except OSError:
                self._hang_up()
                return False
        return not data

    def exchange(self, out: bytes, wait_s: float) -> bytes:
        """Send and listen; a caller who leaves makes room for the next."""
        if self._reader is None:
            self._accepted(wait_s)
            return b""
        try:
            if out:
                with contextlib.suppress(BlockingIOError):
                    self._reader.send(out)
            if select.select([self._reader], [], [], wait_s)[0]:
                if data := self._reader.recv(MAX_READ_BYTES):
                    return data
                raise ConnectionResetError
        except OSError:
            self._hang_up()
        return b""

    def _accepted(self, wait_s: float = STOP_CHECK_S) -> socket.socket | None:
        if self._listener is not None and select.select([self._listener], [], [], wait_s)[0]:
            self._reader, _ = self._listener.accept()
            self._reader.setblocking(False)
            with contextlib.suppress(OSError):  # a caller who has gone already; the first write finds out
                self._reader.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return self._reader

    def _hang_up(self) -> None:
        if self._reader is not None:
            self._reader.close()
            self._reader = None


class UdpLine:
    """A bound UDP socket; it sends to ``to``, else to whoever has written last."""

    def __init__(self, port: int = 0, to: tuple[str, int] | None = None) -> None:
        self._port, self._to, self._peer = port, to, to
        self._socket: socket.socket | None = None

    @property
    def address(self) -> str:
        """How the station reaches it: it listens where this sends, or calls where this listens."""
        return f"udpin://{self._to[0]}:{self._to[1]}" if self._to else f"udpout://{LOOPBACK}:{self._port}"

    def plug(self) -> None:
        """Bind; the same port again after an unplug."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.bind((LOOPBACK, 0 if self._to else self._port))
        if not self._to:
            self._port = self._socket.getsockname()[1]

    def unplug(self) -> None:
        """Close the socket."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def exchange(self, out: bytes, wait_s: float) -> bytes:
        """Send and listen."""
        assert self._socket is not None
        if out and self._peer is not None:
            with contextlib.suppress(OSError):  # nobody there
                self._socket.sendto(out, self._peer)
        if not select.select([self._socket], [], [], wait_s)[0]:
            return b""
        try:
            data, sender = self._socket.recvfrom(MAX_READ_BYTES)
        except OSError:
            return b""
        self._peer = self._to or sender
        return data


MAX_WAITING_BYTES = 4096  # bytes for the station; a bus goes on, but what is simulated waits for its reader
GROUP, PORT = "239.74.163.2", 43113
ERROR, OK = b"\a", b"\r"
BIT_RATES = {b"S": re.compile(rb"[0-8]"), b"s": re.compile(rb"[0-9A-Fa-f]{4}")}
BUS_OFF_FLAGS = 0xA4  # error warning, error passive, bus error
FRAME = re.compile(
    rb"[tr][0-7][0-9A-Fa-f]{2}[0-8](?:[0-9A-Fa-f]{2})*|[TR][01][0-9A-Fa-f]{7}[0-8](?:[0-9A-Fa-f]{2})*"
)


class SlcanAdapter(PtyLine):
    """An slcan adapter; ``ails`` is what is wrong with it, such as ``adapter_hangs`` or ``bus_off``.

    Source: LAWICEL CAN232 manual, 2.0. It answers CR, a value, z or Z, and BEL for what it may not do now.
    """

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
                while not (stop.is_set() or self._gone.is_set()) and (
                    not self._is_open or len(self._out) >= MAX_WAITING_BYTES
                ):
                    self._room.wait(STOP_CHECK_S)
                if stop.is_set() or self._gone.is_set():
                    return False
                self._out += text[at : at + MAX_WAITING_BYTES]
        return True

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
