"""Where a device is: a URL, or what people type instead (`drivers.addresses`), read into a record.

docs/how-to/devices.md, can.md, gnss.md and camera.md list the addresses with their options.
"""

import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from urllib.parse import SplitResult, parse_qsl, unquote, urlencode, urlsplit

from drivers.addresses import (
    CAN,
    DEFAULT_BAUD,
    DEFAULT_PARITY,
    MAVLINK_RATE_HZ,
    TRIAD,
    CameraAddress,
    CanAddress,
    DeviceAddress,
    HttpCameraAddress,
    MavlinkAddress,
    ReplayAddress,
    Role,
    SerialAddress,
    TcpAddress,
    TriadAddress,
    UdpAddress,
    VideoDeviceAddress,
    WheelAddress,
    host_and_port,
    whole_url,
)
from drivers.errors import BadDeviceUrl
from drivers.wire import FORMATS

BAUDS = range(50, 12_500_001)  # Linux takes any number; this is what the fastest USB adapters do
PARITIES = ("N", "E", "O")
SERIAL_OPTIONS, TCP_OPTIONS = ("baud", "format", "parity"), ("format",)
REPLAY_OPTIONS = ("format", "dbc", "map", "period_s", "channel")
TRIAD_OPTIONS = ("x", "y", "z", "format", "baud", "parity")
CAN_OPTIONS = ("dbc", "map", "period_s")  # the others are those of python-can's interface, see docs/how-to/can.md
DEVICE_FILES = {"slcan", "serial", "robotell", "seeedstudio"}  # interfaces whose channel is a file
LINKS = ("udpin", "udpout", "tcp", "serial")  # of MAVLink
MAVLINK = "mavlink:udpin:HOST:PORT, udpout:HOST:PORT, tcp:HOST:PORT or serial:/dev/NAME"
MAVLINK_OPTIONS = ("system", "key", "rate")
MAVLINK_BAUD = 57600  # of telemetry radios and most autopilots' ports
CAMERA = "camera:http://HOST:PORT/PATH or camera:/dev/video0"
WHEEL = "can://INTERFACE/CHANNEL, with a DBC and a signal MESSAGE.SIGNAL of it"
HTTP_PORT = 80
VIDEO_DEVICE = re.compile(r"/dev/[^?/]")
IMAGE_SIZE = re.compile(r"([1-9]\d{0,4})x([1-9]\d{0,4})", re.ASCII)


def parse_device_url(typed: str, role: Role = "imu") -> DeviceAddress:
    """Return the address in a URL, or in what `drivers.addresses` makes one of.

    Raises `BadDeviceUrl` naming what was found and what would be accepted.
    """
    text = whole_url(typed, role)
    scheme, colon, rest = text.partition(":")
    if not colon or scheme not in _PARSERS:
        raise BadDeviceUrl(text, *_unknown(text, scheme if colon else ""))
    return _PARSERS[scheme](text, rest)


def _serial(text: str, _: str) -> SerialAddress:
    parts = _split(text)
    options = _read_options(text, parts.query, SERIAL_OPTIONS)
    name = _format(text, options)
    if parts.netloc or not parts.path.startswith("/") or parts.path == "/":
        raise BadDeviceUrl(text, "no device path", "three slashes: serial:///dev/ttyUSB0")
    usual = (FORMATS[name].baud, FORMATS[name].parity) if name else (DEFAULT_BAUD, DEFAULT_PARITY)
    baud = _whole_number(text, options, "baud", BAUDS) or usual[0]
    parity = _one_of(text, "parity", options.get("parity", usual[1]).upper(), PARITIES)
    return SerialAddress(text, unquote(parts.path), parity, baud=baud, format=name)


def _tcp(text: str, _: str) -> TcpAddress:
    parts = _split(text)
    name = _format(text, _read_options(text, parts.query, TCP_OPTIONS))
    try:
        host, port = parts.hostname, parts.port
    except ValueError:
        host = port = None
    if not host or not port or parts.path or parts.username:
        raise BadDeviceUrl(text, "no usable host and port", "tcp://HOST:PORT with a port from 1 to 65535")
    return TcpAddress(text, host, port, format=name)


def _replay(text: str, rest: str) -> ReplayAddress:
    _refuse_unprintable(text)
    path, _, query = rest.partition("?")
    if not path:
        raise BadDeviceUrl(text, "no file", "replay:FILE")
    options = _read_options(text, query, REPLAY_OPTIONS)
    name = CAN if options.get("format") == CAN or "dbc" in options or "map" in options else _format(text, options)
    described = options.get("dbc", ""), options.get("map", ""), _period(text, options)
    return ReplayAddress(text, unquote(path), *described, options.get("channel"), format=name)


def _triad(text: str, rest: str) -> TriadAddress:
    """Return three addresses as one; format, baud and parity are those of each."""
    _refuse_unprintable(text)
    options = _read_options(text, rest.removeprefix("?"), TRIAD_OPTIONS)
    single = [name for name, wire in FORMATS.items() if len(wire.imu.channels) == 1]
    options["format"] = _one_of(text, "format", options.get("format", single[0]), single)
    axes = list[SerialAddress | TcpAddress]()
    for axis in "xyz":
        if axis not in options:
            raise BadDeviceUrl(text, f"no {axis}", "triad:?x=URL&y=URL&z=URL")
        own = whole_url(options[axis])
        names = TCP_OPTIONS if own.startswith("tcp:") else SERIAL_OPTIONS
        more = {name: options[name] for name in names if name in options and f"{name}=" not in own}
        address = parse_device_url(f"{own}{'&' if '?' in own else '?'}{urlencode(more)}")
        if not isinstance(address, SerialAddress | TcpAddress):
            raise BadDeviceUrl(text, f"{axis} {own!r}", "a serial line or a TCP connection")
        axes.append(address)
    ports = [address.name for address in axes]
    if len(set(ports)) < len(ports):
        raise BadDeviceUrl(text, f"ports {', '.join(ports)}", "three different ones")
    return TriadAddress(text, tuple(axes), format=TRIAD, baud=axes[0].baud)


def _can(text: str, _: str) -> CanAddress:
    parts = _split(text)
    interface, channel = parts.netloc, unquote(parts.path)
    if not interface:
        raise BadDeviceUrl(text, "no interface", "can://INTERFACE/CHANNEL, as in can://slcan/dev/ttyACM0")
    if interface not in DEVICE_FILES:
        channel = channel.removeprefix("/")
    elif channel in {"", "/"}:
        raise BadDeviceUrl(text, "no device path", f"can://{interface}/dev/NAME")
    options = _read_options(text, parts.query)
    others = tuple((name, value) for name, value in options.items() if name not in CAN_OPTIONS)
    described = options.get("dbc", ""), options.get("map", ""), _period(text, options)
    return CanAddress(text, interface, channel, others, *described, format=CAN)


def _wheel(text: str, where: str) -> WheelAddress:
    """Return the address of a CAN bus, one of whose signals is a wheel's speed."""
    if not where.startswith("can://"):
        raise BadDeviceUrl(text, f"{where.partition('?')[0]!r} for where it is", WHEEL)
    bus = _can(where, where)
    options = dict(bus.options)
    signal, unit = options.pop("signal", ""), options.pop("unit", "")
    if not (bus.dbc and signal) or bus.map:
        raise BadDeviceUrl(text, "no dbc and signal", WHEEL)
    return WheelAddress(text, replace(bus, options=tuple(options.items())), signal, unit)


def parse_mavlink_url(text: str) -> MavlinkAddress:
    """Return the address of a MAVLink link; raises as `parse_device_url`."""
    _refuse_unprintable(text)
    address, _, query = text.partition("?")
    link, _, where = address.partition(":")[2].partition(":")
    if link not in LINKS:
        raise BadDeviceUrl(text, f"link {link!r}", MAVLINK)
    options = _read_options(text, query, (*MAVLINK_OPTIONS, "baud") if link == "serial" else MAVLINK_OPTIONS)
    if options.get("key") == "":
        raise BadDeviceUrl(text, "an empty key", "the file that holds it")
    line = _mavlink_line(text, link, where.removeprefix("//"), options)
    return MavlinkAddress(
        text,
        line,
        baud=line.baud,
        system=_whole_number(text, options, "system", range(1, 256)),
        key_file=options.get("key", ""),
        rate_hz=_decimal_number(text, options, "rate", 0.1, 100, "Hz") or MAVLINK_RATE_HZ,
    )


def _mavlink_line(
    text: str, link: str, where: str, options: Mapping[str, str]
) -> SerialAddress | TcpAddress | UdpAddress:
    if link == "serial":
        path = unquote(where)
        if not path.startswith("/") or path == "/":
            raise BadDeviceUrl(text, "no device path", "mavlink:serial:/dev/ttyACM0")
        return SerialAddress(text, path, baud=_whole_number(text, options, "baud", BAUDS) or MAVLINK_BAUD)
    if (peer := host_and_port(where)) is None:
        raise BadDeviceUrl(text, "no usable host and port", MAVLINK)
    return TcpAddress(text, *peer) if link == "tcp" else UdpAddress(text, *peer, listens=link == "udpin")


def _camera(text: str, where: str) -> CameraAddress:
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
    return HttpCameraAddress(text, host, port or HTTP_PORT, target, user, password)


def _video_device(text: str, where: str) -> VideoDeviceAddress:
    path, _, query = where.partition("?")
    options = _read_options(text, query, ("size", "rate"))
    rate_hz = _decimal_number(text, options, "rate", 0.1, 1000, "Hz")
    size = None
    if "size" in options:
        if (found := IMAGE_SIZE.fullmatch(options["size"])) is None:
            raise BadDeviceUrl(text, f"size {options['size']!r}", "WIDTHxHEIGHT, as in size=640x480")
        size = int(found[1]), int(found[2])
    return VideoDeviceAddress(text, unquote(path), size, rate_hz)


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


def _split(text: str) -> SplitResult:
    _refuse_unprintable(text)
    try:
        return urlsplit(text)
    except ValueError as error:
        raise BadDeviceUrl(text, str(error), "serial:///dev/NAME or tcp://HOST:PORT") from error


def _period(text: str, options: Mapping[str, str]) -> float | None:
    """Return the nominal sample period [s]."""
    return _decimal_number(text, options, "period_s", 1e-5, 10, "s")


def _one_of(text: str, name: str, value: str, accepted: Collection[str]) -> str:
    if value not in accepted:
        raise BadDeviceUrl(text, f"{name} {value!r}", f"one of {', '.join(accepted)}")
    return value


def _format(text: str, options: dict[str, str]) -> str | None:
    return _one_of(text, "format", options["format"], FORMATS) if "format" in options else None


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


_PARSERS: dict[str, Callable[[str, str], DeviceAddress]] = {  # of a URL and what follows its scheme
    "serial": _serial,
    "tcp": _tcp,
    "replay": _replay,
    "triad": _triad,
    "can": _can,
    "wheel": _wheel,
    "mavlink": lambda text, _: parse_mavlink_url(text),
    "camera": _camera,
}
