"""Where a camera is.

``camera:http://HOST:PORT/PATH`` is a stream of MJPEG, as mjpg-streamer, ustreamer and most network cameras serve
it; ``USER:PASSWORD@`` before HOST is sent as Basic. ``camera:/dev/video0`` is one of Video4Linux 2; its options
are ``size`` WIDTHxHEIGHT [px] and ``rate`` [Hz], as it has them.
"""

import re
from urllib.parse import unquote, urlsplit

from drivers.device_url import DeviceUrl, decimal_number, read_options
from drivers.errors import BadDeviceUrl

EXPECTED = "camera:http://HOST:PORT/PATH or camera:/dev/video0"
OPTIONS = ("size", "rate")
SIZE = re.compile(r"([1-9]\d{0,4})x([1-9]\d{0,4})", re.ASCII)
DEVICE = re.compile(r"/dev/[^?/]")
HTTP_PORT = 80


def parse_camera_url(text: str) -> DeviceUrl:
    """Return the address in a URL; raise `BadDeviceUrl` naming what was found and what would be accepted."""
    if "%00" in text or not text.isprintable() or " " in text:
        raise BadDeviceUrl(text, "a space, or a character that cannot be printed", "printable text")
    where = text.partition(":")[2]
    if where.startswith("http://"):
        return _stream(text, where)
    if DEVICE.match(where):
        return _device(text, where)
    found = where.partition("://")[0] + "://" if "://" in where else repr(where)
    raise BadDeviceUrl(text, f"{found} for where it is", EXPECTED)


def _stream(text: str, where: str) -> DeviceUrl:
    try:
        parts = urlsplit(where)
        host, port = parts.hostname, parts.port
    except ValueError as error:
        raise BadDeviceUrl(text, str(error), EXPECTED) from error
    if not host or port == 0 or parts.fragment:
        raise BadDeviceUrl(text, "no usable host and port", EXPECTED)
    user, password = (unquote(each or "") for each in (parts.username, parts.password))
    target = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
    if not target.isascii():
        raise BadDeviceUrl(text, "a path that is not ASCII", "it in %XX")
    return DeviceUrl(
        text, "camera", host=host, port=port or HTTP_PORT, target=target, user=user, password=password
    )


def _device(text: str, where: str) -> DeviceUrl:
    path, _, query = where.partition("?")
    options = read_options(text, query, OPTIONS)
    rate_hz = decimal_number(text, options, "rate", 0.1, 1000, "Hz") or 0.0
    return DeviceUrl(text, "camera", path=unquote(path), size=_size(text, options.get("size")), rate_hz=rate_hz)


def _size(text: str, value: str | None) -> tuple[int, int] | None:
    if value is None:
        return None
    found = SIZE.fullmatch(value)
    if found is None:
        raise BadDeviceUrl(text, f"size {value!r}", "WIDTHxHEIGHT, as in size=640x480")
    return int(found[1]), int(found[2])
