"""A TCP connection to a device server, such as a serial-to-Ethernet converter."""

import socket

from drivers.error_reason import reason_of
from drivers.errors import LinkLost, PortNotFound

CONNECT_TIMEOUT_S = 5.0
SEND_TIMEOUT_S = 1.0


class TcpPort:
    """An open connection."""

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
