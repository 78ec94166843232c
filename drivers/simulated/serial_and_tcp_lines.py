"""The lines of simulated devices: pty, TCP and UDP.

``write`` waits for room until it is stopped. Nothing blocks in ``exchange``; what finds no room is lost.

Facts of Linux ptys, measured: without a reader the kernel takes 17408 bytes; the server keeps the far end open
itself, so that a reader may come and go; closing the near end is what a reader sees as unplugged.
"""

import contextlib
import errno
import os
import select
import socket
import tty
from pathlib import Path
from threading import Event

MAX_READ_BYTES = 65535
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

    def __init__(self, host: str = "127.0.0.1", port: int = 0) -> None:
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

    def __init__(self, host: str = "127.0.0.1", port: int = 0, to: tuple[str, int] | None = None) -> None:
        self._host, self._port, self._to = host, port, to
        self._peer = to
        self._socket: socket.socket | None = None

    @property
    def address(self) -> str:
        """How the station reaches it: it listens where this sends, or calls where this listens."""
        return f"udpin://{self._to[0]}:{self._to[1]}" if self._to else f"udpout://{self._host}:{self._port}"

    def plug(self) -> None:
        """Bind; the same port again after an unplug."""
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.bind((self._host, 0 if self._to else self._port))
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
