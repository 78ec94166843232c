"""An attitude told to others: MAVLink ATTITUDE and a heartbeat each second, over UDP.

Source: common.xml, ATTITUDE (30): roll, pitch, yaw [rad] of forward-right-down against north-east-down, body rates
[rad/s], time since boot [ms]. A yaw that is not known is sent as NaN. It comes from component 200, an IMU, which
takes no part in flying.
"""

import math
import time
from collections.abc import Callable

from pymavlink.dialects.v20 import all as dialect

from drivers.device_url import DeviceUrl
from drivers.device_url_parser import parse_mavlink_url
from drivers.errors import BadDeviceUrl
from drivers.mavlink.signing import read_key, signing_time
from drivers.udp_port import UdpPort, open_udp

SYSTEM = 200  # unless the address says another; 1 is the usual vehicle's
HEARTBEAT_S = 1.0
EXPECTED = "udpout:HOST:PORT, or udpin:HOST:PORT for those who ask, with system=N or key=FILE"


class AttitudeOut:
    """Sends to one address; who does not listen is not an error."""

    def __init__(self, address: DeviceUrl, port: UdpPort, clock: Callable[[], float] = time.monotonic) -> None:
        self.port, self._clock, self._next_heartbeat = port, clock, 0.0
        self._mav = dialect.MAVLink(None, srcSystem=address.system or SYSTEM, srcComponent=dialect.MAV_COMP_ID_IMU)
        if address.key_file:
            signing = self._mav.signing
            signing.secret_key, signing.sign_outgoing = read_key(address.key_file), True
            signing.timestamp = signing_time()

    def send(
        self, t: float, roll: float, pitch: float, rate: tuple[float, float, float], yaw: float = math.nan
    ) -> None:
        """Send an attitude [rad] and body rates (3,) [rad/s] of a moment ``t`` [s] of the device."""
        self.port.read(65535)  # so that who asks is known, and nothing piles up
        if self._clock() >= self._next_heartbeat:
            self._next_heartbeat = self._clock() + HEARTBEAT_S
            kind, none = dialect.MAV_TYPE_GENERIC, dialect.MAV_AUTOPILOT_INVALID
            self._say(self._mav.heartbeat_encode(kind, none, 0, 0, dialect.MAV_STATE_ACTIVE))
        self._say(self._mav.attitude_encode(round(t * 1e3) % 2**32, roll, pitch, yaw, *rate))

    def close(self) -> None:
        """Give the port back."""
        self.port.close()

    def _say(self, message: "dialect.MAVLink_message") -> None:
        self.port.write(message.pack(self._mav))
        self._mav.seq = (self._mav.seq + 1) % 256


def open_attitude_out(text: str) -> AttitudeOut:
    """Open what ``udpout:HOST:PORT`` names.

    Raises
    ------
    BadDeviceUrl, PortBusy, PortDenied, PortNotFound
        Each says what was found, what was expected and what to do.
    """
    address = parse_mavlink_url(f"mavlink:{text.removeprefix('mavlink:')}")
    if address.link not in {"udpout", "udpin"}:
        raise BadDeviceUrl(text, f"link {address.link!r}", EXPECTED)
    return AttitudeOut(address, open_udp(address.host, address.port, 0.0, listens=address.link == "udpin"))
