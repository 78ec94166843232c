"""Open a device's URL as a port of bytes: serial line, TCP, CAN bus, replayed file, MAVLink link or camera."""

from contextlib import ExitStack
from typing import cast

from drivers.camera.http_port import open_http_camera
from drivers.device_url import DeviceUrl
from drivers.device_url_parser import CAN, parse_device_url
from drivers.errors import PortNotFound
from drivers.network_ports import TcpPort, open_tcp
from drivers.port_interface import Port, ReplayPort
from drivers.serial_port import PortInfo, SerialPort, list_ports, open_serial
from drivers.wire import FORMATS


def _open_replay(address: DeviceUrl) -> Port:
    """Open a file of raw bytes or a CAN log; raise `PortNotFound` where it cannot be read."""
    path = address.path
    if address.format in {None, CAN}:
        from drivers.can.can_log import form_of, open_can_log  # python-can takes 0.1 s to import

        if (form := form_of(path)) is not None:
            return open_can_log(address, form)
    try:
        file = open(path, "rb")
    except OSError as error:
        reason = f"cannot be replayed ({error.strerror})"
        raise PortNotFound(path, reason, "check the file's name and permissions") from error
    return ReplayPort(file, path)


def open_port(url: str | DeviceUrl, timeout_s: float = 0.05) -> Port:
    """Open the port that a device's URL names.

    Raises
    ------
    BadDeviceUrl, PortNotFound, PortBusy, PortDenied
        Each says what was found, what was expected and what to do.
    """
    address = parse_device_url(url) if isinstance(url, str) else url
    if address.scheme == "mavlink":
        from drivers.mavlink.session import open_mavlink  # pymavlink: only where it is wanted

        return open_mavlink(address, timeout_s)
    if address.scheme == "camera" and address.path:
        from drivers.camera.v4l2_port import open_v4l2  # OpenCV: only where it is wanted

        return open_v4l2(address, timeout_s)
    if address.scheme == "camera":
        return open_http_camera(address, timeout_s)
    if address.scheme == "tcp":
        return open_tcp(address.host, address.port, timeout_s)
    if address.scheme == "triad":
        return _open_triad(address, timeout_s)
    if address.scheme in {"can", "wheel"}:
        from drivers.can.can_port import open_can  # python-can takes 0.1 s to import

        return open_can(address.interface, address.path, dict(address.options), timeout_s)
    if address.scheme == "replay":
        return _open_replay(address)
    return open_serial(address.path, address.baud or 0, address.parity, timeout_s)


def _open_triad(address: DeviceUrl, timeout_s: float) -> Port:
    from drivers.triad_port import TriadPort

    ports = list[SerialPort | TcpPort]()
    with ExitStack() as opened:
        for axis in address.axes:
            ports.append(cast("SerialPort | TcpPort", open_port(axis, timeout_s)))
            opened.callback(ports[-1].close)
        opened.pop_all()  # all three are there: from now on they are the triad's
    return TriadPort(ports, FORMATS[address.axes[0].format or ""], timeout_s)


__all__ = ["DeviceUrl", "Port", "PortInfo", "list_ports", "open_port", "parse_device_url"]
