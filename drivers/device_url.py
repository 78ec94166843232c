"""Where a device is: one URL, read into a frozen record.

``serial:///dev/ttyUSB0?baud=921600&format=rawimusx`` · ``tcp://host:port?format=counts`` · ``replay:FILE``
"""

from collections.abc import Collection
from dataclasses import dataclass
from urllib.parse import parse_qsl, unquote, urlsplit

from drivers.errors import BadDeviceUrl
from drivers.wire import FORMATS

DEFAULT_BAUD = 921600  # the usual one of FOG IMUs; a format's own stands before it
BAUDS = range(50, 12_500_001)  # Linux takes any number; this is what the fastest USB adapters do
PARITIES = ("N", "E", "O")
ACCEPTED = {"serial": ("baud", "format", "parity"), "tcp": ("format",), "replay": ("format",)}


@dataclass(frozen=True, slots=True)
class DeviceUrl:
    """A device's address.

    ``path`` is the serial device or the replayed file; ``host`` and ``port`` are for TCP. ``format`` names a wire
    format, None where the address does not say. ``baud`` [bit/s] and ``parity`` are for serial lines.
    """

    text: str
    scheme: str
    path: str = ""
    host: str = ""
    port: int = 0
    format: str | None = None
    baud: int | None = None
    parity: str = "N"

    @property
    def name(self) -> str:
        """The port in a few characters, as messages name it."""
        return f"{self.host}:{self.port}" if self.scheme == "tcp" else self.path


def parse_device_url(text: str) -> DeviceUrl:
    """Return the address in a URL; raise `BadDeviceUrl` naming what was found and what would be accepted."""
    scheme, colon, rest = text.partition(":")
    if not colon or scheme not in ACCEPTED:
        found = f"scheme {scheme!r}" if colon else "no scheme"
        raise BadDeviceUrl(text, found, "serial:///dev/NAME, tcp://HOST:PORT or replay:FILE")
    if "%00" in text or not text.isprintable():
        raise BadDeviceUrl(text, "a character that cannot be printed", "printable text")
    if scheme == "replay":
        path, _, query = rest.partition("?")
        if not path:
            raise BadDeviceUrl(text, "no file", "replay:FILE")
        return DeviceUrl(text, scheme, path=unquote(path), format=_format(text, _options(text, scheme, query)))
    try:
        parts = urlsplit(text)
    except ValueError as error:
        raise BadDeviceUrl(text, str(error), "serial:///dev/NAME or tcp://HOST:PORT") from error
    options = _options(text, scheme, parts.query)
    format_name = _format(text, options)
    if scheme == "tcp":
        host, port = _host_and_port(text)
        return DeviceUrl(text, scheme, host=host, port=port, format=format_name)
    if parts.netloc or not parts.path.startswith("/") or parts.path == "/":
        raise BadDeviceUrl(text, "no device path", "three slashes: serial:///dev/ttyUSB0")
    return DeviceUrl(
        text,
        scheme,
        path=unquote(parts.path),
        format=format_name,
        baud=_baud(text, options, format_name),
        parity=_parity(text, options, format_name),
    )


def _options(text: str, scheme: str, query: str) -> dict[str, str]:
    options: dict[str, str] = {}
    for name, value in parse_qsl(query, keep_blank_values=True):
        if name not in ACCEPTED[scheme]:
            raise BadDeviceUrl(text, f"option {name!r}", f"one of {', '.join(ACCEPTED[scheme])}")
        if name in options:
            raise BadDeviceUrl(text, f"option {name!r} twice", "each option once")
        options[name] = value
    if query and not options:
        raise BadDeviceUrl(text, f"options {query!r}", f"NAME=VALUE with {', '.join(ACCEPTED[scheme])}")
    return options


def _one_of(text: str, name: str, value: str, accepted: Collection[str]) -> str:
    if value not in accepted:
        raise BadDeviceUrl(text, f"{name} {value!r}", f"one of {', '.join(accepted)}")
    return value


def _format(text: str, options: dict[str, str]) -> str | None:
    return _one_of(text, "format", options["format"], FORMATS) if "format" in options else None


def _baud(text: str, options: dict[str, str], format_name: str | None) -> int:
    if "baud" not in options:
        return FORMATS[format_name].baud if format_name else DEFAULT_BAUD
    value = options["baud"]
    if not (value.isascii() and value.isdigit() and len(value) < 10 and int(value) in BAUDS):
        raise BadDeviceUrl(text, f"baud {value!r}", f"a whole number from {BAUDS[0]} to {BAUDS[-1]}")
    return int(value)


def _parity(text: str, options: dict[str, str], format_name: str | None) -> str:
    usual = FORMATS[format_name].parity if format_name else "N"
    return _one_of(text, "parity", options.get("parity", usual).upper(), PARITIES)


def _host_and_port(text: str) -> tuple[str, int]:
    expected = "tcp://HOST:PORT with a port from 1 to 65535"
    parts = urlsplit(text)
    try:
        host, port = parts.hostname, parts.port
    except ValueError:
        host, port = None, None
    if not host or not port or parts.path or parts.username:
        raise BadDeviceUrl(text, "no usable host and port", expected)
    return host, port
