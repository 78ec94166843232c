"""A MAVLink link as a port of bytes, and the conversation that makes the other side send.

The station says a heartbeat each second, and which messages it wants how often; reading the port keeps this up.
Each SET_MESSAGE_INTERVAL waits for its COMMAND_ACK. What is not accepted, or not answered after three tries, is
asked for by REQUEST_DATA_STREAM, which nobody acknowledges. A system that was silent or restarted is asked again.
"""

import contextlib
import time
from collections import deque
from dataclasses import dataclass

from pymavlink.dialects.v20 import all as dialect

from drivers.addresses import MavlinkAddress, SerialAddress, TcpAddress, UdpAddress
from drivers.errors import LinkLost
from drivers.mavlink import frames as mavlink
from drivers.mavlink.frames import NAMES, SignatureCheck, read_key, signing_time
from drivers.mavlink.gnss_fixes import CommandAnswer, MavlinkDecoder
from drivers.network_ports import open_tcp, open_udp
from drivers.port_interface import Port
from drivers.serial_port import open_serial

STATION, COMPONENT = 254, 190  # not 255, on which failsafes depend; 190: a ground station's program
HEARTBEAT_S = 1.0
ANSWER_S = 1.0
MAX_TRIES = 3
SILENT_S = 5.0  # without a heartbeat: gone, to be asked again
STALE_S = 10.0  # of heartbeats alone: it has forgotten what it was asked
SET_MESSAGE_INTERVAL = 511
ACCEPTED, IN_PROGRESS = 0, 5
RESULTS = ("accepted", "temporarily rejected", "denied", "unsupported", "failed", "in progress", "cancelled")
WANTED = {  # in this order; the MAV_DATA_STREAM in which ArduPilot sends each
    mavlink.GPS_RAW_INT: 2,
    mavlink.SYSTEM_TIME: 12,
    mavlink.GPS2_RAW: 2,
    mavlink.GLOBAL_POSITION_INT: 6,
    mavlink.VFR_HUD: 11,
    mavlink.HIGHRES_IMU: 1,
}


@dataclass(frozen=True, slots=True)
class RequestedMessage:
    """A message asked for, and what came of it: a word of `RESULTS` or ``no answer``."""

    message: str
    rate_hz: float
    outcome: str


class MavlinkSession:
    """One link's conversation; time is given [s, monotonic], bytes go in and out."""

    def __init__(self, rate_hz: float, system: int | None = None, key: bytes | None = None) -> None:
        self._rate_hz = rate_hz
        self._decoder = MavlinkDecoder(system, SignatureCheck(key) if key else None)
        self._mav = dialect.MAVLink(None, srcSystem=STATION, srcComponent=COMPONENT)
        if key:
            signing = self._mav.signing
            signing.secret_key, signing.sign_outgoing, signing.timestamp = key, True, signing_time()
        self._out: list[bytes] = []
        self._next_heartbeat = 0.0
        self._heard = -SILENT_S  # when the last heartbeat came
        self._known_reboots = 0
        self._record_at = 0.0  # when the last record came
        self._to_ask: deque[int] = deque()
        self._tries = 0
        self._until: float | None = None  # an answer is waited for
        self.asked: list[RequestedMessage] = []

    def hear(self, data: bytes, now: float) -> None:
        """Take what has come."""
        heartbeats = self._decoder.heartbeats
        for record in self._decoder.feed(data, round(now * 1e9)):
            self._record_at = now
            if isinstance(record, CommandAnswer) and record.command == SET_MESSAGE_INTERVAL:
                self._answered(record.result, now)
        if self._decoder.heartbeats > heartbeats:
            is_restarted = now - self._heard >= SILENT_S or self._decoder.clock.reboots != self._known_reboots
            if is_restarted or (self._until is None and now - self._record_at >= STALE_S):
                self._begin(now)
            self._heard = now

    def due(self, now: float) -> bytes:
        """Return what is to be sent by now, possibly nothing."""
        if now >= self._next_heartbeat:
            self._next_heartbeat = now + HEARTBEAT_S
            mav = self._mav
            self._say(mav.heartbeat_encode(dialect.MAV_TYPE_GCS, dialect.MAV_AUTOPILOT_INVALID, 0, 0, 4))
        if self._until is not None and now >= self._until:
            if self._tries < MAX_TRIES:
                self._ask(now)
            else:
                self._done("no answer", now)
        out, self._out = b"".join(self._out), []
        return out

    def _begin(self, now: float) -> None:
        self._known_reboots, self._record_at = self._decoder.clock.reboots, now
        self._to_ask, self._tries = deque(WANTED), 0
        self.asked.clear()
        self._ask(now)

    def _ask(self, now: float) -> None:
        self._tries += 1
        self._until = now + ANSWER_S
        parameters = self._to_ask[0], 1e6 / self._rate_hz, 0, 0, 0, 0, 0
        self._say(self._mav.command_long_encode(*self._target, SET_MESSAGE_INTERVAL, self._tries - 1, *parameters))

    def _answered(self, result: int, now: float) -> None:
        if self._until is None:  # late, of a question given up
            return
        if result == IN_PROGRESS:
            self._until = now + ANSWER_S
        else:
            self._done(RESULTS[result] if result < len(RESULTS) else f"result {result}", now)

    def _done(self, outcome: str, now: float) -> None:
        number, self._until, self._tries = self._to_ask.popleft(), None, 0
        self.asked.append(RequestedMessage(NAMES[number], self._rate_hz, outcome))
        if outcome != RESULTS[ACCEPTED]:
            rate = max(1, round(self._rate_hz))
            self._say(self._mav.request_data_stream_encode(*self._target, WANTED[number], rate, 1))
        if self._to_ask:
            self._ask(now)

    @property
    def _target(self) -> tuple[int, int]:
        return self._decoder.system or 0, self._decoder.component

    def _say(self, message: "dialect.MAVLink_message") -> None:
        self._out.append(message.pack(self._mav))
        self._mav.seq = (self._mav.seq + 1) % 256


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


def open_mavlink(address: MavlinkAddress, timeout_s: float) -> MavlinkPort:
    """Open the link that an address names; raises what its port raises, `BadDeviceUrl` for a bad key file."""
    key = read_key(address.key_file) if address.key_file else None
    port: Port
    match address.line:
        case TcpAddress(host=host, port=number):
            port = open_tcp(host, number, timeout_s)
        case SerialAddress(path=path, baud=baud, parity=parity):
            port = open_serial(path, baud, parity, timeout_s)
        case UdpAddress(host=host, port=number, listens=listens):
            port = open_udp(host, number, timeout_s, listens=listens)
    return MavlinkPort(port, MavlinkSession(address.rate_hz, address.system, key))
