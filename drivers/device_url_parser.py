"""Where a device is: one URL, read into a frozen record.

``serial:///dev/ttyUSB0?baud=921600&format=rawimusx`` · ``tcp://host:port?format=counts`` · ``replay:FILE`` ·
``can://slcan/dev/ttyACM0?bitrate=1000000&dbc=FILE&map=FILE`` ·
``triad:?x=serial:///dev/ttyUSB0&y=serial:///dev/ttyUSB1&z=serial:///dev/ttyUSB2&format=ch70``.
What people type instead, such as ``/dev/ttyUSB0`` or ``imu.local:5000``: `drivers.address_guess`.

``mavlink:udpin:HOST:PORT`` listens, ``mavlink:udpout:HOST:PORT`` calls, ``mavlink:tcp:HOST:PORT`` connects,
``mavlink:serial:/dev/NAME?baud=57600`` opens a line. Options: ``system`` the one to read, ``key`` a file with the
signing key, ``rate`` [Hz] of what is asked for.

``camera:http://HOST:PORT/PATH`` is a stream of MJPEG, as mjpg-streamer, ustreamer and most network cameras serve
it; ``USER:PASSWORD@`` before HOST is sent as Basic. ``camera:/dev/video0`` is one of Video4Linux 2; its options
are ``size`` WIDTHxHEIGHT [px] and ``rate`` [Hz], as it has them.

``wheel:can://INTERFACE/CHANNEL?dbc=FILE&signal=MESSAGE.SIGNAL`` is a vehicle's speed on a CAN bus, in the DBC's
unit or in ``unit``.
"""

import re
from collections.abc import Collection, Mapping
from dataclasses import replace
from urllib.parse import parse_qsl, unquote, urlencode, urlsplit

from drivers.address_guess import Role, whole_url
from drivers.device_url import DEFAULT_BAUD, DeviceUrl
from drivers.errors import BadDeviceUrl
from drivers.wire import FORMATS

BAUDS = range(50, 12_500_001)  # Linux takes any number; this is what the fastest USB adapters do
PARITIES = ("N", "E", "O")
ACCEPTED = {
    "serial": ("baud", "format", "parity"),
    "tcp": ("format",),
    "replay": ("format", "dbc", "map", "period_s", "channel"),
    "triad": ("x", "y", "z", "format", "baud", "parity"),
}
TRIAD = "triad"  # three single-axis gyros; also the format of what their port gives
CAN_OPTIONS = ("dbc", "map", "period_s")  # the others are those of python-can's interface, see docs/how-to/can.md
CAN = "can"  # the format of a CAN bus, as `dbc` and `map` describe it
DEVICE_FILES = {"slcan", "serial", "robotell", "seeedstudio"}  # interfaces whose channel is a file
LINKS = ("udpin", "udpout", "tcp", "serial")  # of MAVLink
MAVLINK = "mavlink:udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT or serial:/dev/NAME"
MAVLINK_OPTIONS = ("system", "key", "rate")
MAVLINK_BAUD = 57600  # of telemetry radios and most autopilots' ports
MAVLINK_RATE_HZ = 5.0
CAMERA = "camera:http://HOST:PORT/PATH or camera:/dev/video0"
WHEEL = "can://INTERFACE/CHANNEL, with a DBC and a signal MESSAGE.SIGNAL of it"
HTTP_PORT = 80
VIDEO_DEVICE = re.compile(r"/dev/[^?/]")
IMAGE_SIZE = re.compile(r"([1-9]\d{0,4})x([1-9]\d{0,4})", re.ASCII)


def parse_device_url(typed: str, role: Role = "imu") -> DeviceUrl:
    """Return the address in a URL, or in what `drivers.address_guess` makes one of.

    Raises `BadDeviceUrl` naming what was found and what would be accepted.
    """
    text = whole_url(typed, role)
    scheme, colon, rest = text.partition(":")
    if scheme == "mavlink":
        return parse_mavlink_url(text)
    if scheme == "camera":
        return _camera(text, rest)
    if scheme == "wheel":
        return _wheel(text, rest)
    if not colon or scheme not in {*ACCEPTED, CAN}:
        raise BadDeviceUrl(text, *_unknown(text, scheme if colon else ""))
    _refuse_unprintable(text)
    if scheme == "replay":
        return _replay(text, rest)
    if scheme == TRIAD:
        return _triad(text, rest)
    try:
        parts = urlsplit(text)
    except ValueError as error:
        raise BadDeviceUrl(text, str(error), "serial:///dev/NAME or tcp://HOST:PORT") from error
    if scheme == CAN:
        return _can(text, parts.netloc, parts.path, parts.query)
    options = _read_options(text, parts.query, ACCEPTED[scheme])
    format_name = _format(text, options)
    if scheme == "tcp":
        try:
            host, port = parts.hostname, parts.port
        except ValueError:
            host = port = None
        if not host or not port or parts.path or parts.username:
            raise BadDeviceUrl(text, "no usable host and port", "tcp://HOST:PORT with a port from 1 to 65535")
        return DeviceUrl(text, scheme, host=host, port=port, format=format_name)
    if parts.netloc or not parts.path.startswith("/") or parts.path == "/":
        raise BadDeviceUrl(text, "no device path", "three slashes: serial:///dev/ttyUSB0")
    usual = (FORMATS[format_name].baud, FORMATS[format_name].parity) if format_name else (DEFAULT_BAUD, "N")
    return DeviceUrl(
        text,
        scheme,
        path=unquote(parts.path),
        format=format_name,
        baud=_whole_number(text, options, "baud", BAUDS) or usual[0],
        parity=_one_of(text, "parity", options.get("parity", usual[1]).upper(), PARITIES),
    )


def _unknown(text: str, scheme: str) -> tuple[str, str]:
    """Return what was found and what to type instead."""
    if re.fullmatch(r"COM\d+", text, re.IGNORECASE):
        return "a port of Windows", "one of this machine, such as /dev/ttyUSB0; `station devices` lists them"
    if re.fullmatch(r"[\w-]+(\.[\w-]+)+", text):
        return "a host without a port, or a file that is not there", f"HOST:PORT, as in {text}:5000"
    found = f"scheme {scheme!r}" if scheme else "no address"
    return found, (
        "/dev/NAME, HOST:PORT, can0, a file to replay, can://INTERFACE/CHANNEL, triad:?x=..., mavlink:LINK:WHERE, "
        "camera:http://HOST:PORT/PATH, serial:///dev/NAME, tcp://HOST:PORT or replay:FILE"
    )


def _replay(text: str, rest: str) -> DeviceUrl:
    path, _, query = rest.partition("?")
    if not path:
        raise BadDeviceUrl(text, "no file", "replay:FILE")
    options = _read_options(text, query, ACCEPTED["replay"])
    name = CAN if options.get("format") == CAN or "dbc" in options or "map" in options else _format(text, options)
    channel = tuple((key, value) for key, value in options.items() if key == "channel")
    return _described(DeviceUrl(text, "replay", path=unquote(path), format=name, options=channel), options)


def _triad(text: str, rest: str) -> DeviceUrl:
    """Return three addresses as one; format, baud and parity are those of each."""
    options = _read_options(text, rest.removeprefix("?"), ACCEPTED[TRIAD])
    single = [name for name, wire in FORMATS.items() if len(wire.imu.channels) == 1]
    options["format"] = _one_of(text, "format", options.get("format", single[0]), single)
    axes = list[DeviceUrl]()
    for axis in "xyz":
        if axis not in options:
            raise BadDeviceUrl(text, f"no {axis}", "triad:?x=URL&y=URL&z=URL")
        own = whole_url(options[axis])
        names = ("format",) if own.startswith("tcp:") else ("format", "baud", "parity")
        more = {name: options[name] for name in names if name in options and f"{name}=" not in own}
        address = parse_device_url(f"{own}{'&' if '?' in own else '?'}{urlencode(more)}")
        if address.scheme not in {"serial", "tcp"}:
            raise BadDeviceUrl(text, f"{axis} {own!r}", "a serial line or a TCP connection")
        axes.append(address)
    ports = [address.name for address in axes]
    if len(set(ports)) < len(ports):
        raise BadDeviceUrl(text, f"ports {', '.join(ports)}", "three different ones")
    return DeviceUrl(text, TRIAD, path=", ".join(ports), format=TRIAD, baud=axes[0].baud, axes=tuple(axes))


def _can(text: str, interface: str, path: str, query: str) -> DeviceUrl:
    if not interface:
        raise BadDeviceUrl(text, "no interface", "can://INTERFACE/CHANNEL, as in can://slcan/dev/ttyACM0")
    channel = unquote(path)
    if interface not in DEVICE_FILES:
        channel = channel.removeprefix("/")
    elif channel in {"", "/"}:
        raise BadDeviceUrl(text, "no device path", f"can://{interface}/dev/NAME")
    options = _read_options(text, query)
    others = tuple((name, value) for name, value in options.items() if name not in CAN_OPTIONS)
    address = DeviceUrl(text, CAN, path=channel, format=CAN, interface=interface, options=others)
    return _described(address, options)


def _described(address: DeviceUrl, options: Mapping[str, str]) -> DeviceUrl:
    """Return the address with the options that say how frames are to be read."""
    period = _decimal_number(address.text, options, "period_s", 1e-5, 10, "s")
    return replace(address, dbc=options.get("dbc", ""), map=options.get("map", ""), period=period)


def _one_of(text: str, name: str, value: str, accepted: Collection[str]) -> str:
    if value not in accepted:
        raise BadDeviceUrl(text, f"{name} {value!r}", f"one of {', '.join(accepted)}")
    return value


def _format(text: str, options: dict[str, str]) -> str | None:
    return _one_of(text, "format", options["format"], FORMATS) if "format" in options else None


def parse_mavlink_url(text: str) -> DeviceUrl:
    """Return the address of a MAVLink link; raises as `parse_device_url`."""
    _refuse_unprintable(text)
    address, _, query = text.partition("?")
    link, _, where = address.partition(":")[2].partition(":")
    if link not in LINKS:
        raise BadDeviceUrl(text, f"link {link!r}", MAVLINK)
    options = _read_options(text, query, (*MAVLINK_OPTIONS, "baud") if link == "serial" else MAVLINK_OPTIONS)
    if options.get("key") == "":
        raise BadDeviceUrl(text, "an empty key", "the file that holds it")
    path, host, port, baud = "", "", "0", None
    if link == "serial":
        path = unquote(where).removeprefix("//")
        if not path.startswith("/") or path == "/":
            raise BadDeviceUrl(text, "no device path", "mavlink:serial:/dev/ttyACM0")
        baud = _whole_number(text, options, "baud", BAUDS) or MAVLINK_BAUD
    else:
        host, _, port = where.removeprefix("//").rpartition(":")
        if not host or not (port.isascii() and port.isdigit()) or not 0 < int(port[:6]) < 65536:
            raise BadDeviceUrl(text, "no usable host and port", MAVLINK)
    return DeviceUrl(
        text,
        "mavlink",
        path=path,
        host=host.strip("[]"),
        port=int(port),
        baud=baud,
        link=link,
        system=_whole_number(text, options, "system", range(1, 256)),
        key_file=options.get("key", ""),
        rate_hz=_decimal_number(text, options, "rate", 0.1, 100, "Hz") or MAVLINK_RATE_HZ,
    )


def _camera(text: str, where: str) -> DeviceUrl:
    if "%00" in text or not text.isprintable() or " " in text:
        raise BadDeviceUrl(text, "a space, or a character that cannot be printed", "printable text")
    if VIDEO_DEVICE.match(where):
        return _video_device(text, where)
    if not where.startswith("http://"):
        found = where.partition("://")[0] + "://" if "://" in where else repr(where)
        raise BadDeviceUrl(text, f"{found} for where it is", CAMERA)
    try:
        parts = urlsplit(where)
        host, port = parts.hostname, parts.port
    except ValueError as error:
        raise BadDeviceUrl(text, str(error), CAMERA) from error
    if not host or port == 0 or parts.fragment:
        raise BadDeviceUrl(text, "no usable host and port", CAMERA)
    user, password = (unquote(each or "") for each in (parts.username, parts.password))
    target = (parts.path or "/") + (f"?{parts.query}" if parts.query else "")
    if not target.isascii():
        raise BadDeviceUrl(text, "a path that is not ASCII", "it in %XX")
    address = DeviceUrl(text, "camera", host=host, port=port or HTTP_PORT, target=target)
    return replace(address, user=user, password=password)


def _wheel(text: str, where: str) -> DeviceUrl:
    """Return the address of a CAN bus, one of whose signals is a wheel's speed."""
    if not where.startswith("can://"):
        raise BadDeviceUrl(text, f"{where.partition('?')[0]!r} for where it is", WHEEL)
    address = parse_device_url(where)
    options = dict(address.options)
    signal, unit = options.pop("signal", ""), options.pop("unit", "")
    if not (address.dbc and signal) or address.map:
        raise BadDeviceUrl(text, "no dbc and signal", WHEEL)
    others = tuple(options.items())
    return replace(address, text=text, scheme="wheel", format=None, options=others, signal=signal, unit=unit)


def _video_device(text: str, where: str) -> DeviceUrl:
    path, _, query = where.partition("?")
    options = _read_options(text, query, ("size", "rate"))
    rate_hz = _decimal_number(text, options, "rate", 0.1, 1000, "Hz") or 0.0
    size = None
    if "size" in options:
        if (found := IMAGE_SIZE.fullmatch(options["size"])) is None:
            raise BadDeviceUrl(text, f"size {options['size']!r}", "WIDTHxHEIGHT, as in size=640x480")
        size = int(found[1]), int(found[2])
    return DeviceUrl(text, "camera", path=unquote(path), size=size, rate_hz=rate_hz)


def _refuse_unprintable(text: str) -> None:
    """Raise `BadDeviceUrl` for a URL with a character that cannot be printed."""
    if "%00" in text or not text.isprintable():
        raise BadDeviceUrl(text, "a character that cannot be printed", "printable text")


def _read_options(text: str, query: str, accepted: Collection[str] | None = None) -> dict[str, str]:
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


def _whole_number(text: str, options: Mapping[str, str], name: str, accepted: range) -> int | None:
    """Return an option within a range, None where it is not given."""
    if name not in options:
        return None
    value = options[name]
    if not (value.isascii() and value.isdigit() and len(value) < 10 and int(value) in accepted):
        raise BadDeviceUrl(text, f"{name} {value!r}", f"a whole number from {accepted[0]} to {accepted[-1]}")
    return int(value)


def _decimal_number(
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
