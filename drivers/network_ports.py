"""TCP and UDP as ports of bytes: a connection to a device server, datagrams and answers to whoever sent them."""

import contextlib
import errno
import select
import socket
from collections import deque

from drivers.errors import LinkLost, PortBusy, PortDenied, PortNotFound, reason_of

MAX_DATAGRAM_BYTES = 65535
RECEIVE_BUFFER_BYTES = 2**20  # bytes: a burst of many seconds while the reader is held up
MAX_PEERS = 8

Address = tuple[str, int]


class UdpPort:
    """A bound socket; ``peer`` is whom to write to, None: all who have sent, the last `MAX_PEERS` of them.

    ``refused`` counts the datagrams that this machine did not take: no room, no way there.
    """

    def __init__(self, socket_: socket.socket, name: str, timeout_s: float, peer: Address | None) -> None:
        self.name = name
        self._socket, self._timeout_s, self._peer = socket_, timeout_s, peer
        self._senders: deque[Address] = deque(maxlen=MAX_PEERS)
        self.refused = 0

    def read(self, max_bytes: int) -> bytes:
        """Return the datagrams that have come, end to end, empty after the timeout."""
        try:
            if not select.select([self._socket], [], [], self._timeout_s)[0]:
                return b""
            parts, size = list[bytes](), 0
            while size < max_bytes and (data := self._receive()) is not None:
                parts.append(data)
                size += len(data)
        except (OSError, ValueError) as error:  # ValueError: select on a closed socket
            raise LinkLost(self.name, reason_of(error)) from error
        return b"".join(parts)

    def write(self, data: bytes) -> None:
        """Send ``data`` as one datagram; who is not there is not an error of UDP."""
        for peer in [self._peer] if self._peer else list(self._senders):
            try:
                self._socket.sendto(data, peer)
            except OSError as error:
                if error.errno == errno.EBADF:
                    raise LinkLost(self.name, "closed") from error
                self.refused += error.errno != errno.ECONNREFUSED  # that only says nobody listens

    @property
    def peers(self) -> int:
        """How many are written to."""
        return 1 if self._peer else len(self._senders)

    def close(self) -> None:
        """Give the port back."""
        self._socket.close()

    def _receive(self) -> bytes | None:
        try:
            data, sender = self._socket.recvfrom(MAX_DATAGRAM_BYTES)
        except BlockingIOError:
            return None
        except ConnectionRefusedError:  # a datagram of ours met a closed port: the peer is not there yet
            return b""
        if sender not in self._senders:
            self._senders.append(sender)
        return data


def open_udp(host: str, port: int, timeout_s: float, *, listens: bool) -> UdpPort:
    """Bind to ``host:port`` if it ``listens``, else to any port, to send there.

    Raises `PortBusy`, `PortDenied` or `PortNotFound` if the address is taken, not permitted or not one of this
    machine.
    """
    name = f"{host}:{port}"
    try:
        family, _, _, _, where = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
        bound = socket.socket(family, socket.SOCK_DGRAM)
    except (OSError, UnicodeError) as error:
        raise PortNotFound(name, f"no such address ({reason_of(error)})", "check host and port") from error
    try:
        bound.setblocking(False)
        with contextlib.suppress(OSError):
            bound.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER_BYTES)
        if listens:
            bound.bind(where)
    except OSError as error:
        bound.close()
        if error.errno == errno.EADDRINUSE:
            raise PortBusy(name) from error
        if error.errno in {errno.EACCES, errno.EPERM}:
            raise PortDenied(name) from error
        raise PortNotFound(name, reason_of(error), "use an address of this machine") from error
    return UdpPort(bound, name, timeout_s, None if listens else (str(where[0]), int(where[1])))


CONNECT_TIMEOUT_S = 5.0
SEND_TIMEOUT_S = 1.0


class TcpPort:
    """An open connection, such as to a serial-to-Ethernet converter."""

    def __init__(self, connection: socket.socket, name: str, timeout_s: float) -> None:
        self.name = name
        self.timeout_s = timeout_s  # of a read
        self._socket = connection

    def read(self, max_bytes: int) -> bytes:
        """Return what has come, empty after the timeout."""
        try:
            self._socket.settimeout(self.timeout_s)
            data = self._socket.recv(max_bytes)
        except TimeoutError:
            return b""
        except OSError as error:
            raise LinkLost(self.name, reason_of(error)) from error
        if not data:
            raise LinkLost(self.name, "closed by the other side")
        return data

    def fileno(self) -> int:
        """Return what `select` takes."""
        return self._socket.fileno()

    def write(self, data: bytes) -> None:
        """Send ``data`` whole."""
        try:
            self._socket.settimeout(SEND_TIMEOUT_S)
            self._socket.sendall(data)
        except OSError as error:
            raise LinkLost(self.name, reason_of(error)) from error

    def close(self) -> None:
        """Hang up."""
        self._socket.close()


def open_tcp(host: str, port: int, timeout_s: float) -> TcpPort:
    """Connect to a device server; raise `PortNotFound` if none answers in 5 s, `LinkLost` if it hangs up."""
    name = f"{host}:{port}"
    try:
        connection = socket.create_connection((host, port), timeout=CONNECT_TIMEOUT_S)
    except (OSError, UnicodeError) as error:  # the latter from a host name that is none
        reason = f"no connection ({reason_of(error)})"
        raise PortNotFound(name, reason, "check address, port and that the server runs") from error
    try:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    except OSError as error:  # the other side has already hung up
        connection.close()
        raise LinkLost(name, reason_of(error)) from error
    return TcpPort(connection, name, timeout_s)
