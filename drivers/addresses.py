"""A device's address as a record, one class for each kind; `drivers.address_parsing` reads them from URLs.

Every kind has a ``scheme`` and a short ``name`` for messages. `whole_url` makes a URL of an address as people type
it: such an address says where, not what, which follows from who asks.
"""

import os
import re
import stat
from dataclasses import dataclass, field
from typing import ClassVar, Literal
from urllib.parse import quote, unquote, unquote_plus

# of a serial line, the usual ones of FOG IMUs; a format's own take precedence
DEFAULT_BAUD, DEFAULT_PARITY = 921600, "N"
MAVLINK_RATE_HZ = 5.0  # of the messages that are asked for, where the address states none
CAN = "can"  # the format of a CAN bus, as `dbc` and `map` describe it
TRIAD = "triad"  # three single-axis gyros; also the format of what their port gives
_SECRET = re.compile(r"(http://[^/:@]*:)[^/]*@")


def host_and_port(text: str, least: int = 1) -> tuple[str, int] | None:
    """Return host and port of HOST:PORT, None where it is none or the port is not ``least`` to 65535.

    An IPv6 address stands in brackets, which are left out: ``[::1]:5000``.
    """
    host, _, port = text.strip().rpartition(":")
    if not host or not (port.isascii() and port.isdigit() and len(port) <= 5) or not least <= int(port) < 65536:
        return None
    return host.removeprefix("[").removesuffix("]"), int(port)


@dataclass(frozen=True, slots=True)
class Address:
    """What all kinds have: the URL as it was read, the format of its bytes, the rate [bit/s] of its line."""

    text: str
    format: str | None = field(default=None, kw_only=True)
    baud: int | None = field(default=None, kw_only=True)

    @property
    def public_text(self) -> str:
        """The URL without its password, as it may be written down and shown."""
        return self.text


@dataclass(frozen=True, slots=True)
class SerialAddress(Address):
    """A serial line by its device file; 8 data bits, 1 stop bit."""

    scheme: ClassVar[Literal["serial"]] = "serial"
    path: str
    baud: int = field(default=DEFAULT_BAUD, kw_only=True)
    parity: str = DEFAULT_PARITY

    @property
    def name(self) -> str:
        """The device file."""
        return self.path


@dataclass(frozen=True, slots=True)
class TcpAddress(Address):
    """A TCP connection to a device server."""

    scheme: ClassVar[Literal["tcp"]] = "tcp"
    host: str
    port: int

    @property
    def name(self) -> str:
        """Host and port."""
        return f"{self.host}:{self.port}"


@dataclass(frozen=True, slots=True)
class UdpAddress(Address):
    """UDP: it listens at host and port, or sends there."""

    scheme: ClassVar[Literal["udp"]] = "udp"
    host: str
    port: int
    listens: bool

    @property
    def name(self) -> str:
        """Direction, host and port."""
        return f"{'udpin' if self.listens else 'udpout'}:{self.host}:{self.port}"


@dataclass(frozen=True, slots=True)
class TriadAddress(Address):
    """Three single-axis gyros: the addresses of x, y and z."""

    scheme: ClassVar[Literal["triad"]] = "triad"
    axes: tuple[SerialAddress | TcpAddress, ...]

    @property
    def name(self) -> str:
        """The three ports."""
        return ", ".join(axis.name for axis in self.axes)


@dataclass(frozen=True, slots=True)
class CanAddress(Address):
    """A CAN bus by python-can's name of an interface and its channel.

    ``options`` are further arguments of the interface. ``dbc`` and ``map`` are the files that describe the frames;
    ``period`` [s] takes precedence over the one in them.
    """

    scheme: ClassVar[Literal["can"]] = "can"
    interface: str
    channel: str
    options: tuple[tuple[str, str], ...] = ()
    dbc: str = ""
    map: str = ""
    period: float | None = None

    @property
    def name(self) -> str:
        """The channel, or the interface where it has none."""
        return self.channel or self.interface


@dataclass(frozen=True, slots=True)
class WheelAddress(Address):
    """A vehicle's speed on a CAN bus: ``signal`` of the bus's DBC, in ``unit`` where that is not the DBC's."""

    scheme: ClassVar[Literal["wheel"]] = "wheel"
    bus: CanAddress
    signal: str
    unit: str = ""

    @property
    def name(self) -> str:
        """That of the bus."""
        return self.bus.name


@dataclass(frozen=True, slots=True)
class ReplayAddress(Address):
    """A recorded file: of raw bytes, or a CAN log, then with the fields of a `CanAddress` and one ``channel``."""

    scheme: ClassVar[Literal["replay"]] = "replay"
    path: str
    dbc: str = ""
    map: str = ""
    period: float | None = None
    channel: str | None = None

    @property
    def name(self) -> str:
        """The file."""
        return self.path


@dataclass(frozen=True, slots=True)
class MavlinkAddress(Address):
    """A MAVLink link: what it is sent over, and the system to read, None for any.

    ``key_file`` holds the signing key, empty for unsigned; ``rate_hz`` is asked for.
    """

    scheme: ClassVar[Literal["mavlink"]] = "mavlink"
    line: SerialAddress | TcpAddress | UdpAddress
    system: int | None = None
    key_file: str = ""
    rate_hz: float = MAVLINK_RATE_HZ

    @property
    def name(self) -> str:
        """The line; with its kind where it is a network's."""
        return f"tcp:{self.line.name}" if isinstance(self.line, TcpAddress) else self.line.name


@dataclass(frozen=True, slots=True)
class HttpCameraAddress(Address):
    """A stream of MJPEG: ``target`` is its path at the host; user and password are sent as Basic."""

    scheme: ClassVar[Literal["camera"]] = "camera"
    host: str
    port: int
    target: str
    user: str = ""
    password: str = ""

    @property
    def name(self) -> str:
        """Host, port and path."""
        return f"{self.host}:{self.port}{self.target}"

    @property
    def public_text(self) -> str:
        """The URL without its password, as it may be written down and shown."""
        return _SECRET.sub(r"\1***@", self.text)


@dataclass(frozen=True, slots=True)
class VideoDeviceAddress(Address):
    """A camera of Video4Linux 2 by its device file; ``size`` [px] and ``rate_hz`` are asked for, if given."""

    scheme: ClassVar[Literal["camera"]] = "camera"
    path: str
    size: tuple[int, int] | None = None
    rate_hz: float | None = None

    @property
    def name(self) -> str:
        """The device file."""
        return self.path


CameraAddress = HttpCameraAddress | VideoDeviceAddress
ImuAddress = SerialAddress | TcpAddress | TriadAddress | CanAddress | ReplayAddress
DeviceAddress = ImuAddress | MavlinkAddress | CameraAddress | WheelAddress


Role = Literal["imu", "receiver", "camera"]
_QUERY = r"(?P<query>\?.*)?"
_DEVICE = re.compile(rf"(?P<path>/dev/[^?]+|tty[A-Z]\w*|video\d+){_QUERY}")
_HOST = re.compile(r"(\[[0-9A-Fa-f:.]+\]|[\w.-]+):\d{1,5}([/?].*)?", re.ASCII)
_CAN = re.compile(rf"(?P<name>(v|sl)?can\d+){_QUERY}", re.ASCII)
_UDP = re.compile(rf"(?P<way>udp|udpin|udpout):(//)?((?P<host>[^?]+):)?(?P<port>\d{{1,5}}){_QUERY}", re.ASCII)
_SERIAL = re.compile(r"serial:/{0,2}(?P<path>/?[^/].*)")
_TCP = re.compile(r"tcp:/?(?P<where>[^/].*)")
_FILE_OPTION = re.compile(r"(?<=[?&])(dbc|map|key)=([^&]+)")
_REPLAY = re.compile(r"^(replay:)([^?]+)")
_RECORDED = re.compile(r".*(/|\.(mcap|bin|dat|raw|log|csv|txt)$)")


def whole_url(text: str, role: Role = "imu") -> str:
    """Return what was typed as a URL; as it is where it is one, or where nothing can be made of it."""
    typed = text.strip()
    path = typed.partition("?")[0]
    if _is_device(path):
        return _of_device(os.path.abspath(path) + typed[len(path) :], role)
    if found := _DEVICE.fullmatch(typed):
        return _of_device(typed if typed.startswith("/") else f"/dev/{typed}", role)
    if found := _UDP.fullmatch(typed):
        way = "udpin" if found["way"] == "udp" else found["way"]  # without a host it hears this machine alone
        return f"mavlink:{way}:{found['host'] or '127.0.0.1'}:{found['port']}{found['query'] or ''}"
    if found := _CAN.fullmatch(typed):
        return f"can://socketcan/{found['name']}{found['query'] or ''}"
    if found := _SERIAL.fullmatch(typed):  # nobody remembers how many slashes
        return f"serial://{'' if found['path'].startswith('/') else '/'}{found['path']}"
    if found := _TCP.fullmatch(typed):
        return f"tcp://{found['where']}"
    if _HOST.fullmatch(typed):
        return {"imu": "tcp://", "receiver": "mavlink:tcp:", "camera": "camera:http://"}[role] + typed
    if typed.startswith("http://"):
        return f"camera:{typed}"
    if ":" not in path and (os.path.isfile(path) or _RECORDED.fullmatch(path)):
        return f"replay:{typed}"
    return text


def with_absolute_paths(typed: str, role: Role = "imu") -> str:
    """Return an address as a URL whose files are found from any folder, so that it can be used on another day."""
    url = whole_url(typed, role)
    found = _FILE_OPTION.sub(
        lambda each: f"{each[1]}={quote(os.path.abspath(unquote_plus(each[2])), safe='/')}", url
    )
    return _REPLAY.sub(lambda each: each[1] + quote(os.path.abspath(unquote(each[2])), safe="/"), found)


def _is_device(path: str) -> bool:
    try:
        return ":" not in path and stat.S_ISCHR(os.stat(path).st_mode)
    except (OSError, ValueError):
        return False


def _of_device(path: str, role: Role) -> str:
    if role == "camera" or path.startswith("/dev/video"):
        return f"camera:{path}"
    return f"mavlink:serial:{path}" if role == "receiver" else f"serial://{path}"
