"""What an IMU, component 200, sends by MAVLink over UDP: ATTITUDE, or HIGHRES_IMU, and a heartbeat each second.

Source: common.xml. Both are forward-right-down; ATTITUDE is against north-east-down, a yaw that is not known NaN.
"""

import math
import time
from collections.abc import Callable

from pymavlink.dialects.v20 import all as dialect

from drivers.address_parsing import parse_mavlink_url
from drivers.addresses import MavlinkAddress, UdpAddress
from drivers.errors import BadDeviceUrl
from drivers.mavlink.frames import read_key, signing_time
from drivers.network_ports import UdpPort, open_udp

SYSTEM = 200  # unless the address says another; 1 is the usual vehicle's
HEARTBEAT_S = 1.0
EXPECTED = "udpout:HOST:PORT, or udpin:HOST:PORT for those who ask, with system=N or key=FILE"
FORCE = dialect.HIGHRES_IMU_UPDATED_XACC | dialect.HIGHRES_IMU_UPDATED_YACC | dialect.HIGHRES_IMU_UPDATED_ZACC
RATE = dialect.HIGHRES_IMU_UPDATED_XGYRO | dialect.HIGHRES_IMU_UPDATED_YGYRO | dialect.HIGHRES_IMU_UPDATED_ZGYRO
Three = tuple[float, float, float]


class ImuOut:
    """Sends to one address; who does not listen is not an error."""

    def __init__(
        self, address: MavlinkAddress, port: UdpPort, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.port, self._clock, self._next_heartbeat = port, clock, 0.0
        self._mav = dialect.MAVLink(None, srcSystem=address.system or SYSTEM, srcComponent=dialect.MAV_COMP_ID_IMU)
        if address.key_file:
            signing = self._mav.signing
            signing.secret_key, signing.sign_outgoing = read_key(address.key_file), True
            signing.timestamp = signing_time()

    def attitude(self, t: float, roll: float, pitch: float, rate: Three, yaw: float = math.nan) -> None:
        """Send an attitude [rad] and body rates (3,) [rad/s] of a moment ``t`` [s] of the device."""
        self.keep_up()
        self._say(self._mav.attitude_encode(round(t * 1e3) % 2**32, roll, pitch, yaw, *rate))

    def highres(self, t: float, force: Three, rate: Three, temperature: float = math.nan) -> None:
        """Send specific force (3,) [m/s2], rates (3,) [rad/s] and a temperature [degC] of a device time ``t`` [s].

        Call `keep_up` now and then. What is not measured stands as 0 and is not among the fields updated.
        """
        knows = math.isfinite(temperature)
        updated = dialect.HIGHRES_IMU_UPDATED_TEMPERATURE if knows else 0
        updated |= FORCE if all(map(math.isfinite, force)) else 0
        updated |= RATE if all(map(math.isfinite, rate)) else 0
        none = (0.0, 0.0, 0.0)
        six = (*(force if updated & FORCE else none), *(rate if updated & RATE else none))
        others = (*none, *none, temperature if knows else 0.0)  # magnetic field, two pressures, altitude
        self._say(self._mav.highres_imu_encode(round(t * 1e6) % 2**64, *six, *others, updated))

    def keep_up(self) -> None:
        """Hear who asks, and send the heartbeat when it is due."""
        self.port.read(65535)  # nothing piles up
        if self._clock() >= self._next_heartbeat:
            self._next_heartbeat = self._clock() + HEARTBEAT_S
            kind, none = dialect.MAV_TYPE_GENERIC, dialect.MAV_AUTOPILOT_INVALID
            self._say(self._mav.heartbeat_encode(kind, none, 0, 0, dialect.MAV_STATE_ACTIVE))

    def close(self) -> None:
        """Give the port back."""
        self.port.close()

    def _say(self, message: "dialect.MAVLink_message") -> None:
        self.port.write(message.pack(self._mav))
        self._mav.seq = (self._mav.seq + 1) % 256


def open_imu_out(text: str) -> ImuOut:
    """Open what ``udpout:HOST:PORT`` names.

    Raises `BadDeviceUrl`, `PortBusy`, `PortDenied` or `PortNotFound`: each says what was found, what was expected
    and what to do.
    """
    address = parse_mavlink_url(f"mavlink:{text.removeprefix('mavlink:')}")
    line = address.line
    if not isinstance(line, UdpAddress):
        raise BadDeviceUrl(text, f"link {line.scheme!r}", EXPECTED)
    return ImuOut(address, open_udp(line.host, line.port, 0.0, listens=line.listens))
