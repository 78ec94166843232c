"""A device's address as a record, and how the options of every kind of address are read."""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from urllib.parse import parse_qsl

from drivers.errors import BadDeviceUrl

SECRET = re.compile(r"(http://[^/:@]*:)[^/]*@")
DEFAULT_BAUD = 921600  # the usual one of FOG IMUs; a format's own stands before it
BAUDS = range(50, 12_500_001)  # Linux takes any number; this is what the fastest USB adapters do


@dataclass(frozen=True, slots=True)
class DeviceUrl:
    """A device's address.

    ``path`` is the serial device or the replayed file; ``host`` and ``port`` are for TCP. ``format`` names a
    wire format, None where the address does not say. ``baud`` [bit/s] and ``parity`` are for serial lines.
    ``interface`` is python-can's name of a CAN adapter, ``path`` then its channel and ``options`` what else it
    is told; ``axes`` are the addresses of a triad's x, y and z; ``dbc`` and ``map`` are the files that describe
    the frames, ``period`` [s] stands before theirs. MAVLink's ``link`` is how a ``system``, None for any, is
    reached; ``key_file`` is empty for unsigned. A camera's ``target`` is a stream's path at its host, ``size``
    [px] is asked of a device, None for what it has. ``rate_hz`` is asked of either, 0 for what it has.
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

    @property
    def name(self) -> str:
        """The port in a few characters, as messages name it."""
        link = f"{self.link}:" if self.link else ""
        return self.path or self.interface or f"{link}{self.host}:{self.port}{self.target}"

    @property
    def public_text(self) -> str:
        """The URL without its password, as it may be written down and shown."""
        return SECRET.sub(r"\1***@", self.text)


def refuse_unprintable(text: str) -> None:
    """Raise `BadDeviceUrl` for a URL with a character that cannot be printed."""
    if "%00" in text or not text.isprintable():
        raise BadDeviceUrl(text, "a character that cannot be printed", "printable text")


def read_options(text: str, query: str, accepted: Collection[str] | None = None) -> dict[str, str]:
    """Return the options of a URL's query, each once; any name where ``accepted`` is None."""
    options: dict[str, str] = {}
    for name, value in parse_qsl(query, keep_blank_values=True):
        if accepted is not None and name not in accepted:
            raise BadDeviceUrl(text, f"option {name!r}", f"one of {', '.join(accepted)}")
        if name in options:
            raise BadDeviceUrl(text, f"option {name!r} twice", "each option once")
        options[name] = value
    if query and not options:
        raise BadDeviceUrl(text, f"options {query!r}", "NAME=VALUE")
    return options


def whole_number(text: str, options: Mapping[str, str], name: str, accepted: range) -> int | None:
    """Return an option within a range, None where it is not given."""
    if name not in options:
        return None
    value = options[name]
    if not (value.isascii() and value.isdigit() and len(value) < 10 and int(value) in accepted):
        raise BadDeviceUrl(text, f"{name} {value!r}", f"a whole number from {accepted[0]} to {accepted[-1]}")
    return int(value)


def decimal_number(
    text: str, options: Mapping[str, str], name: str, low: float, high: float, unit: str
) -> float | None:
    """Return an option from ``low`` to ``high``, None where it is not given."""
    if name not in options:
        return None
    try:
        value = float(options[name])
    except ValueError:
        value = float("nan")
    if not low <= value <= high:
        raise BadDeviceUrl(text, f"{name} {options[name]!r}", f"{low:g} to {high:g} [{unit}]")
    return value
