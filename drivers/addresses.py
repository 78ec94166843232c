"""A device's address as a record, one class for each kind; `drivers.address_parsing` reads them from URLs.

Every kind has its URL as ``text``, ``public_text`` without a password, a short ``name`` for messages, its
``scheme``, the ``format`` of its bytes and the ``baud`` rate [bit/s] of its line, None where there is none.
"""

import re
from dataclasses import dataclass
from typing import ClassVar, Literal

DEFAULT_BAUD = 921600  # the usual one of FOG IMUs; a format's own takes precedence
MAVLINK_RATE_HZ = 5.0  # of the messages that are asked for, where the address states none
CAN = "can"  # the format of a CAN bus, as `dbc` and `map` describe it
TRIAD = "triad"  # three single-axis gyros; also the format of what their port gives
_SECRET = re.compile(r"(http://[^/:@]*:)[^/]*@")


@dataclass(frozen=True, slots=True)
class Address:
    """What all kinds have: the URL as it was read."""

    text: str

    @property
    def public_text(self) -> str:
        """The URL without its password, as it may be written down and shown."""
        return self.text


@dataclass(frozen=True, slots=True)
class SerialAddress(Address):
    """A serial line by its device file; 8 data bits, 1 stop bit."""

    scheme: ClassVar[Literal["serial"]] = "serial"
    path: str
    baud: int = DEFAULT_BAUD
    parity: str = "N"
    format: str | None = None

    @property
    def name(self) -> str:
        """The device file."""
        return self.path


@dataclass(frozen=True, slots=True)
class TcpAddress(Address):
    """A TCP connection to a device server."""

    scheme: ClassVar[Literal["tcp"]] = "tcp"
    baud: ClassVar[None] = None
    host: str
    port: int
    format: str | None = None

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
    format: ClassVar[str] = TRIAD
    axes: tuple[SerialAddress | TcpAddress, ...]

    @property
    def name(self) -> str:
        """The three ports."""
        return ", ".join(axis.name for axis in self.axes)

    @property
    def baud(self) -> int | None:
        """That of x."""
        return self.axes[0].baud


@dataclass(frozen=True, slots=True)
class CanAddress(Address):
    """A CAN bus by python-can's name of an interface and its channel.

    ``options`` are further arguments of the interface. ``dbc`` and ``map`` are the files that describe the frames;
    ``period`` [s] takes precedence over the one in them.
    """

    scheme: ClassVar[Literal["can"]] = "can"
    format: ClassVar[str] = CAN
    baud: ClassVar[None] = None
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
    format: ClassVar[None] = None
    baud: ClassVar[None] = None
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
    baud: ClassVar[None] = None
    path: str
    format: str | None = None
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
    format: ClassVar[None] = None
    line: SerialAddress | TcpAddress | UdpAddress
    system: int | None = None
    key_file: str = ""
    rate_hz: float = MAVLINK_RATE_HZ

    @property
    def name(self) -> str:
        """The line; with its kind where it is a network's."""
        return f"tcp:{self.line.name}" if isinstance(self.line, TcpAddress) else self.line.name

    @property
    def baud(self) -> int | None:
        """That of a serial line."""
        return self.line.baud if isinstance(self.line, SerialAddress) else None


@dataclass(frozen=True, slots=True)
class HttpCameraAddress(Address):
    """A stream of MJPEG: ``target`` is its path at the host; user and password are sent as Basic."""

    scheme: ClassVar[Literal["camera"]] = "camera"
    format: ClassVar[None] = None
    baud: ClassVar[None] = None
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
    format: ClassVar[None] = None
    baud: ClassVar[None] = None
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
