"""Where a MAVLink system is.

``mavlink:udpin:HOST:PORT`` listens, ``mavlink:udpout:HOST:PORT`` calls, ``mavlink:tcp:HOST:PORT`` connects,
``mavlink:serial:/dev/NAME?baud=57600`` opens a line. Options: ``system`` the one to read, ``key`` a file with the
signing key, ``rate`` [Hz] of what is asked for.
"""

from urllib.parse import unquote

from drivers.device_url import BAUDS, DeviceUrl, decimal_number, read_options, refuse_unprintable, whole_number
from drivers.errors import BadDeviceUrl

LINKS = ("udpin", "udpout", "tcp", "serial")
OPTIONS = ("system", "key", "rate", "baud")
EXPECTED = "mavlink:udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT or serial:/dev/NAME"
BAUD = 57600  # of telemetry radios and most autopilots' ports
RATE_HZ = 5.0


def parse_mavlink_url(text: str) -> DeviceUrl:
    """Return the address in a URL; raise `BadDeviceUrl` naming what was found and what would be accepted."""
    refuse_unprintable(text)
    address, _, query = text.partition("?")
    _, _, rest = address.partition(":")
    link, _, where = rest.partition(":")
    if link not in LINKS:
        raise BadDeviceUrl(text, f"link {link!r}", EXPECTED)
    options = read_options(text, query, OPTIONS if link == "serial" else OPTIONS[:-1])
    if options.get("key") == "":
        raise BadDeviceUrl(text, "an empty key", "the file that holds it")
    path, host, port = "", "", 0
    if link == "serial":
        path = unquote(where).removeprefix("//")
        if not path.startswith("/") or path == "/":
            raise BadDeviceUrl(text, "no device path", "mavlink:serial:/dev/ttyACM0")
    else:
        host, port = _host_and_port(text, where)
    return DeviceUrl(
        text=text,
        scheme="mavlink",
        path=path,
        host=host,
        port=port,
        baud=(whole_number(text, options, "baud", BAUDS) or BAUD) if link == "serial" else None,
        link=link,
        system=whole_number(text, options, "system", range(1, 256)),
        key_file=options.get("key", ""),
        rate_hz=decimal_number(text, options, "rate", 0.1, 100, "Hz") or RATE_HZ,
    )


def _host_and_port(text: str, where: str) -> tuple[str, int]:
    host, _, port = where.removeprefix("//").rpartition(":")
    if not host or not (port.isascii() and port.isdigit()) or not 0 < int(port[:6]) < 65536:
        raise BadDeviceUrl(text, "no usable host and port", EXPECTED)
    return host.strip("[]"), int(port)
