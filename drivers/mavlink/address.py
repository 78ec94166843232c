"""Where a MAVLink system is.

``mavlink:udpin:HOST:PORT`` listens, ``mavlink:udpout:HOST:PORT`` calls, ``mavlink:tcp:HOST:PORT`` connects,
``mavlink:serial:/dev/NAME?baud=57600`` opens a line. Options: ``system`` the one to read, ``key`` a file with the
signing key, ``rate`` [Hz] of what is asked for.
"""

from dataclasses import dataclass
from urllib.parse import parse_qsl, unquote

from drivers.device_url import BAUDS, DeviceUrl
from drivers.errors import BadDeviceUrl

LINKS = ("udpin", "udpout", "tcp", "serial")
OPTIONS = ("system", "key", "rate", "baud")
EXPECTED = "mavlink:udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT or serial:/dev/NAME"
BAUD = 57600  # of telemetry radios and most autopilots' ports
RATE_HZ = 5.0


@dataclass(frozen=True, slots=True)
class MavlinkUrl(DeviceUrl):
    """A MAVLink address: ``link`` is how it is reached, ``key_file`` empty for unsigned."""

    link: str = ""
    system: int | None = None
    key_file: str = ""
    rate_hz: float = RATE_HZ

    @property
    def name(self) -> str:
        """The link in a few characters, as messages name it."""
        return self.path if self.link == "serial" else f"{self.link}:{self.host}:{self.port}"


def parse_mavlink_url(text: str) -> MavlinkUrl:
    """Return the address in a URL; raise `BadDeviceUrl` naming what was found and what would be accepted."""
    if "%00" in text or not text.isprintable():
        raise BadDeviceUrl(text, "a character that cannot be printed", "printable text")
    address, _, query = text.partition("?")
    _, _, rest = address.partition(":")
    link, _, where = rest.partition(":")
    if link not in LINKS:
        raise BadDeviceUrl(text, f"link {link!r}", EXPECTED)
    options = _options(text, query, link)
    path, host, port = "", "", 0
    if link == "serial":
        path = unquote(where).removeprefix("//")
        if not path.startswith("/") or path == "/":
            raise BadDeviceUrl(text, "no device path", "mavlink:serial:/dev/ttyACM0")
    else:
        host, port = _host_and_port(text, where)
    return MavlinkUrl(
        text=text,
        scheme="mavlink",
        path=path,
        host=host,
        port=port,
        baud=_number(text, options, "baud", BAUDS[0], BAUDS[-1], BAUD) if link == "serial" else None,
        link=link,
        system=_number(text, options, "system", 1, 255, None),
        key_file=options.get("key", ""),
        rate_hz=_rate(text, options),
    )


def _options(text: str, query: str, link: str) -> dict[str, str]:
    options: dict[str, str] = {}
    accepted = OPTIONS if link == "serial" else OPTIONS[:-1]
    for name, value in parse_qsl(query, keep_blank_values=True):
        if name not in accepted:
            raise BadDeviceUrl(text, f"option {name!r}", f"one of {', '.join(accepted)}")
        if name in options:
            raise BadDeviceUrl(text, f"option {name!r} twice", "each option once")
        options[name] = value
    if query and not options:
        raise BadDeviceUrl(text, f"options {query!r}", f"NAME=VALUE with {', '.join(accepted)}")
    if options.get("key") == "":
        raise BadDeviceUrl(text, "an empty key", "the file that holds it")
    return options


def _host_and_port(text: str, where: str) -> tuple[str, int]:
    host, _, port = where.removeprefix("//").rpartition(":")
    if not host or not (port.isascii() and port.isdigit()) or not 0 < int(port[:6]) < 65536:
        raise BadDeviceUrl(text, "no usable host and port", EXPECTED)
    return host.strip("[]"), int(port)


def _number(text: str, options: dict[str, str], name: str, low: int, high: int, default: int | None) -> int | None:
    if name not in options:
        return default
    value = options[name]
    if not (value.isascii() and value.isdigit() and len(value) < 10 and low <= int(value) <= high):
        raise BadDeviceUrl(text, f"{name} {value!r}", f"a whole number from {low} to {high}")
    return int(value)


def _rate(text: str, options: dict[str, str]) -> float:
    value = options.get("rate", str(RATE_HZ))
    try:
        rate = float(value)
    except ValueError:
        rate = 0.0
    if not 0.1 <= rate <= 100:
        raise BadDeviceUrl(text, f"rate {value!r}", "0.1 to 100 [Hz]")
    return rate
