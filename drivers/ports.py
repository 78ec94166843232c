"""Open a device's address as a port of bytes, and say in which wire format its bytes are.

What takes long to import, such as python-can (0.1 s) or OpenCV, is imported only where it is wanted.
"""

from contextlib import ExitStack
from typing import cast

from drivers.address_parsing import parse_device_url
from drivers.addresses import (
    CAN,
    CanAddress,
    DeviceAddress,
    HttpCameraAddress,
    MavlinkAddress,
    ReplayAddress,
    SerialAddress,
    TcpAddress,
    TriadAddress,
    VideoDeviceAddress,
    WheelAddress,
)
from drivers.camera.http_port import open_http_camera
from drivers.errors import PortNotFound
from drivers.network_ports import TcpPort, open_tcp
from drivers.port_interface import Port, ReplayPort
from drivers.serial_port import SerialPort, open_serial
from drivers.wire import FORMATS, WireFormat


def open_port(url: str | DeviceAddress, timeout_s: float = 0.05) -> Port:
    """Open the port that a device's address names.

    Raises `BadDeviceUrl`, `PortNotFound`, `PortBusy` or `PortDenied`: each says what was found, what was expected
    and what to do.
    """
    address = parse_device_url(url) if isinstance(url, str) else url
    match address:
        case SerialAddress():
            return open_serial(address.path, address.baud, address.parity, timeout_s)
        case TcpAddress():
            return open_tcp(address.host, address.port, timeout_s)
        case TriadAddress():
            return _open_triad(address, timeout_s)
        case CanAddress():
            from drivers.can.can_port import open_can

            return open_can(address.interface, address.channel, dict(address.options), timeout_s)
        case WheelAddress():
            return open_port(address.bus, timeout_s)
        case ReplayAddress():
            return _open_replay(address)
        case MavlinkAddress():
            from drivers.mavlink.session import open_mavlink

            return open_mavlink(address, timeout_s)
        case HttpCameraAddress():
            return open_http_camera(address, timeout_s)
        case VideoDeviceAddress():
            from drivers.camera.v4l2_port import open_v4l2

            return open_v4l2(address, timeout_s)


def _open_replay(address: ReplayAddress) -> Port:
    """Open a file of raw bytes or a CAN log; raise `PortNotFound` where it cannot be read."""
    path = address.path
    if address.format in {None, CAN}:
        from drivers.can.can_log import form_of, open_can_log

        if (form := form_of(path)) is not None:
            return open_can_log(address, form)
    try:
        file = open(path, "rb")
    except OSError as error:
        reason = f"cannot be replayed ({error.strerror})"
        raise PortNotFound(path, reason, "check the file's name and permissions") from error
    return ReplayPort(file, path)


def _open_triad(address: TriadAddress, timeout_s: float) -> Port:
    from drivers.triad_port import TriadPort

    ports = list[SerialPort | TcpPort]()
    with ExitStack() as opened:
        for axis in address.axes:
            ports.append(cast("SerialPort | TcpPort", open_port(axis, timeout_s)))
            opened.callback(ports[-1].close)
        opened.pop_all()  # all three are there: from now on they are the triad's
    return TriadPort(ports, FORMATS[address.axes[0].format or ""], timeout_s)


def wire_of(address: DeviceAddress) -> WireFormat | None:
    """Return the format, None where the address does not say; raise `BadCanFile` for a wrong DBC or mapping."""
    if address.format is None:
        return None
    if isinstance(address, CanAddress | ReplayAddress) and address.format == CAN:
        from drivers.can.can_format import can_format  # cantools takes 0.15 s to import

        return can_format(address.dbc, address.map, address.period)
    return FORMATS[address.format]


def frame_descriptions(address: DeviceAddress) -> dict[str, str]:
    """Return the texts of the files that the address needs to be read, by what they are.

    They are recorded with the bytes: without them nobody can say what the frames meant.
    """
    if isinstance(address, WheelAddress):
        from drivers.can.dbc_signals import text_of

        return {"dbc": text_of(address.bus.dbc)}
    if isinstance(address, CanAddress | ReplayAddress) and address.format == CAN:
        from drivers.can.can_format import OWN_DBC, OWN_MAP
        from drivers.can.dbc_signals import text_of

        return {"dbc": text_of(address.dbc or OWN_DBC), "map": text_of(address.map or OWN_MAP)}
    return {}
