"""A camera's stream over HTTP/1.0, so that no server divides it into chunks of its own."""

import time
from base64 import b64encode
from contextlib import ExitStack

from drivers.addresses import HttpCameraAddress
from drivers.errors import LinkLost, PortNotFound
from drivers.network_ports import TcpPort, open_tcp

ANSWER_S = 5.0
SILENT_S = 10.0  # a camera that lost its power does not hang up; as long as OpenCV waits for a device
MAX_ANSWER_BYTES = 65536  # bytes before the stream begins
STREAM = "multipart/x-mixed-replace"
PATHS = "check the path: ustreamer has /stream, mjpg-streamer /?action=stream"


class HttpCameraPort:
    """An open stream; ``first_bytes`` is what of it came with the answer."""

    def __init__(self, connection: TcpPort, name: str, first_bytes: bytes) -> None:
        self.name = name
        self._connection, self._first_bytes = connection, first_bytes
        self._heard = time.monotonic()

    def read(self, max_bytes: int) -> bytes:
        """Return what has come, empty after the timeout; raise `LinkLost` after 10 s of nothing."""
        if self._first_bytes:
            data, self._first_bytes = self._first_bytes[:max_bytes], self._first_bytes[max_bytes:]
            return data
        data = self._connection.read(max_bytes)
        now = time.monotonic()
        if data:
            self._heard = now
        elif now - self._heard > SILENT_S:
            raise LinkLost(self.name, f"nothing for {SILENT_S:.0f} s")
        return data

    def write(self, data: bytes) -> None:
        """Send nothing: a stream takes nothing."""

    def close(self) -> None:
        """Hang up."""
        self._connection.close()


def open_http_camera(address: HttpCameraAddress, timeout_s: float) -> HttpCameraPort:
    """Ask for a stream.

    Raises `PortNotFound` if nobody answers within 5 s, or the answer is no stream of images. Raises `LinkLost` if
    it hangs up before it has answered.
    """
    with ExitStack() as opened:
        connection = open_tcp(address.host, address.port, ANSWER_S)
        opened.callback(connection.close)
        connection.write(_request(address))
        head, first_bytes = _answer(connection, address.name)
        _check(head, address)
        opened.pop_all()  # it is a stream: from now on it is the port's
    connection.timeout_s = timeout_s
    return HttpCameraPort(connection, address.name, first_bytes)


def _request(address: HttpCameraAddress) -> bytes:
    host = f"[{address.host}]" if ":" in address.host else address.host
    lines = [f"GET {address.target} HTTP/1.0", f"Host: {host}:{address.port}", f"Accept: {STREAM}, image/*"]
    if address.user or address.password:
        secret = b64encode(f"{address.user}:{address.password}".encode()).decode()
        lines.append(f"Authorization: Basic {secret}")
    return "\r\n".join([*lines, "", ""]).encode()


def _answer(connection: TcpPort, name: str) -> tuple[str, bytes]:
    """Return the answer's head and what follows it."""
    data, until = b"", time.monotonic() + ANSWER_S
    while b"\r\n\r\n" not in data:
        if time.monotonic() > until or len(data) > MAX_ANSWER_BYTES:
            found = f"{len(data)} bytes that are no answer of HTTP within {ANSWER_S:.0f} s"
            raise PortNotFound(name, found, "check the port")
        data += connection.read(MAX_ANSWER_BYTES)
    head, _, first_bytes = data.partition(b"\r\n\r\n")
    return head.decode("latin-1"), first_bytes


def _check(head: str, address: HttpCameraAddress) -> None:
    status, *lines = head.split("\r\n")
    words = status.split(None, 2)
    if len(words) < 2 or not words[0].startswith("HTTP/"):
        raise PortNotFound(address.name, f"{status[:40]!r} for an answer of HTTP", "check the port")
    fields = {name.strip().lower(): value.strip() for name, _, value in (line.partition(":") for line in lines)}
    if words[1] == "401":
        raise PortNotFound(address.name, "it asks who you are", "say camera:http://USER:PASSWORD@HOST:PORT/PATH")
    if words[1] != "200":
        moved = f" (it names {fields['location'][:80]})" if "location" in fields else ""
        raise PortNotFound(address.name, f"the answer is {' '.join(words[1:])[:60]}{moved}", PATHS)
    kind = fields.get("content-type", "no content type")
    if not kind.lower().startswith(STREAM) or "transfer-encoding" in fields:
        found = kind if "transfer-encoding" not in fields else f"transfer-encoding {fields['transfer-encoding']}"
        raise PortNotFound(address.name, f"it sends {found[:60]}, not {STREAM}", PATHS)
