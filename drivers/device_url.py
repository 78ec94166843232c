"""A device's address as a record."""

import re
from dataclasses import dataclass

SECRET = re.compile(r"(http://[^/:@]*:)[^/]*@")
DEFAULT_BAUD = 921600  # the usual one of FOG IMUs; a format's own stands before it


@dataclass(frozen=True, slots=True)
class DeviceUrl:
    """A device's address.

    ``path`` is the serial device or the replayed file; ``host`` and ``port`` are for TCP. ``format`` names a
    wire format, None where the address does not say. ``baud`` [bit/s] and ``parity`` are for serial lines.
    ``interface`` is python-can's name of a CAN adapter, ``path`` then its channel and ``options`` what else it
    is told; ``axes`` are the addresses of a triad's x, y and z; ``dbc`` and ``map`` are the files that describe
    the frames, ``period`` [s] stands before theirs. MAVLink's ``link`` is how a ``system``, None for any, is
    reached; ``key_file`` is empty for unsigned. A camera's ``target`` is a stream's path at its host, ``size``
    [px] is asked of a device, None for what it has. ``rate_hz`` is asked of either, 0 for what it has. A wheel's
    ``signal`` of ``dbc`` tells its speed, in ``unit`` where that is not the DBC's.
    """

    text: str
    scheme: str
    path: str = ""
    host: str = ""
    port: int = 0
    format: str | None = None
    baud: int | None = None
    parity: str = "N"
    interface: str = ""
    dbc: str = ""
    map: str = ""
    period: float | None = None
    options: tuple[tuple[str, str], ...] = ()
    axes: tuple["DeviceUrl", ...] = ()
    link: str = ""
    system: int | None = None
    key_file: str = ""
    rate_hz: float = 0.0
    target: str = ""
    user: str = ""
    password: str = ""
    size: tuple[int, int] | None = None
    signal: str = ""
    unit: str = ""

    @property
    def name(self) -> str:
        """The port in a few characters, as messages name it."""
        link = f"{self.link}:" if self.link else ""
        return self.path or self.interface or f"{link}{self.host}:{self.port}{self.target}"

    @property
    def public_text(self) -> str:
        """The URL without its password, as it may be written down and shown."""
        return SECRET.sub(r"\1***@", self.text)
