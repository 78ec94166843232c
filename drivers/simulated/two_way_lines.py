"""Lines on which a simulated device also listens: UDP, TCP and pty. Nothing blocks; what finds no room is lost."""

import contextlib
import os
import select
import socket
from pathlib import Path
from typing import Protocol

from drivers.simulated.lines import PtyLine

MAX_READ_BYTES = 65535


class Talk(Protocol):
    """Bytes both ways."""

    @property
    def address(self) -> str:
        """What follows ``mavlink:`` in the URL by which it is opened."""
        ...

    def plug(self) -> None:
        """Make the port be there."""
        ...

    def unplug(self) -> None:
        """Make the port be gone; may be called twice."""
        ...

    def exchange(self, out: bytes, wait_s: float) -> bytes:
        """Send ``out``, wait at most ``wait_s`` for what comes, and return it."""
        ...


class PtyTalk(PtyLine):
    """A pseudo terminal."""

    @property
    def address(self) -> str:
        """The link, or the terminal itself."""
        return f"serial:{self._link.absolute() if self._link else self._name}"

    def exchange(self, out: bytes, wait_s: float) -> bytes:
        """Send and listen."""
        with contextlib.suppress(BlockingIOError):
            os.write(self._near, out)
        if select.select([self._near], [], [], wait_s)[0]:
            return os.read(self._near, MAX_READ_BYTES)
        return b""


class UdpTalk:
    """A bound UDP socket; it sends to ``to``, else to whoever has written last."""

    def __init__(self, host: str = "127.0.0.1", port: int = 0, to: tuple[str, int] | None = None) -> None:
        self._host, self._port, self._to = host, port, to
        self._peer = to
        self._socket: socket.socket | None = None

    @property
    def address(self) -> str:
        """How the station reaches it: it listens where this sends, or calls where this listens."""
        return f"udpin:{self._to[0]}:{self._to[1]}" if self._to else f"udpout:{self._host}:{self._port}"

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


class TcpTalk:
    """A listening TCP port; one caller at a time."""

    def __init__(self, host: str = "127.0.0.1", port: int = 0) -> None:
        self._host, self._port = host, port
        self._listener: socket.socket | None = None
        self._caller: socket.socket | None = None

    @property
    def address(self) -> str:
        """Where it listens."""
        return f"tcp:{self._host}:{self._port}"

    def plug(self) -> None:
        """Listen; the same port again after an unplug."""
        self._listener = socket.create_server((self._host, self._port))
        self._port = self._listener.getsockname()[1]

    def unplug(self) -> None:
        """Hang up and stop listening."""
        for one in (self._listener, self._caller):
            if one is not None:
                one.close()
        self._listener = self._caller = None

    def exchange(self, out: bytes, wait_s: float) -> bytes:
        """Send and listen; a caller who leaves makes room for the next."""
        assert self._listener is not None
        if self._caller is None:
            if select.select([self._listener], [], [], wait_s)[0]:
                self._caller, _ = self._listener.accept()
                self._caller.setblocking(False)
            return b""
        try:
            if out:
                with contextlib.suppress(BlockingIOError):
                    self._caller.send(out)
            if select.select([self._caller], [], [], wait_s)[0]:
                if data := self._caller.recv(MAX_READ_BYTES):
                    return data
                raise ConnectionResetError
        except OSError:
            self._caller.close()
            self._caller = None
        return b""


def talk_on(transport: str, link: Path | None, port: int, to: tuple[str, int] | None) -> Talk:
    """Return the line of a transport: ``udp``, ``tcp`` or ``pty``."""
    if transport == "pty":
        return PtyTalk(link)
    if transport == "tcp":
        return TcpTalk(port=port)
    if transport == "udp":
        return UdpTalk(port=port, to=to)
    raise ValueError(f"transport {transport!r}: expected udp, tcp or pty")


__all__ = ["PtyTalk", "Talk", "TcpTalk", "UdpTalk", "talk_on"]
