"""A MAVLink link as a port of bytes: reading it also keeps the conversation that makes the other side send.

So a reader that knows nothing of MAVLink journals a link like any other device.
"""

import contextlib
import time

from drivers.device_url import DeviceUrl
from drivers.errors import LinkLost
from drivers.mavlink.session import MavlinkSession
from drivers.mavlink.signing import read_key
from drivers.port_interface import Port
from drivers.serial_port import open_serial
from drivers.tcp_port import open_tcp
from drivers.udp_port import open_udp


class MavlinkPort:
    """Bytes as they come; `drivers.port_interface.Port`."""

    def __init__(self, line: Port, session: MavlinkSession) -> None:
        self._line, self.session = line, session

    def read(self, max_bytes: int) -> bytes:
        """Return what has come, empty after the timeout; say what is due."""
        if out := self.session.due(time.monotonic()):
            with contextlib.suppress(LinkLost):  # the read that follows says so, after what had still come
                self._line.write(out)
        data = self._line.read(max_bytes)
        if data:
            self.session.hear(data, time.monotonic())
        return data

    def write(self, data: bytes) -> None:
        """Send ``data`` whole."""
        self._line.write(data)

    def close(self) -> None:
        """Give the port back."""
        self._line.close()


def open_mavlink(address: DeviceUrl, timeout_s: float) -> MavlinkPort:
    """Open the link that an address names; raises what its port raises, `BadDeviceUrl` for a bad key file."""
    key = read_key(address.key_file) if address.key_file else None
    line: Port
    if address.link == "tcp":
        line = open_tcp(address.host, address.port, timeout_s)
    elif address.link == "serial":
        line = open_serial(address.path, address.baud or 0, "N", timeout_s)
    else:
        line = open_udp(address.host, address.port, timeout_s, listens=address.link == "udpin")
    return MavlinkPort(line, MavlinkSession(address.rate_hz, address.system, key))
