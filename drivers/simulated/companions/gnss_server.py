"""A simulated autopilot with a GNSS receiver, served by UDP, TCP or pty, with a simulated IMU or alone.

The receiver's error of position is a first-order Gauss-Markov process (minutes long, as multipath and atmosphere
are), that of velocity white. Bytes are made and read by pymavlink itself: station and simulator share no reader.
Equal seeds and times give equal bytes, but for signatures, which hold the time of day.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pymavlink.dialects.v20 import all as dialect

from drivers.mavlink import frames as mavlink
from drivers.mavlink.frames import signing_time
from drivers.simulated.companions.companion_device import CompanionDevice
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.faults import TimedFault, active
from drivers.simulated.lines import PtyLine, TcpLine, UdpLine
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import VehicleTrack
from procedures.arrays import FloatArray

CORRELATION_S = 60.0
UP_TO_LEVEL = 1.6  # vertical over horizontal sigma
AXIS, ECCENTRICITY2 = 6_378_137.0, 6.69437999014e-3  # WGS 84, apart from what it is judged by
UNKNOWN = 65535


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedFix:
    """A moment's fix as the receiver of ``autopilot`` has it [deg, m, m/s]; ``v_n`` (3,) is East-North-Up."""

    latitude: float
    longitude: float
    height: float
    v_n: FloatArray
    has_fix: bool
    autopilot: AutopilotTruth

    def gps_raw_int(self, stamp_us: int) -> "dialect.MAVLink_message":
        """Return a GPS_RAW_INT."""
        return dialect.MAVLink_gps_raw_int_message(stamp_us, *self._common(), *self._extension())

    def gps2_raw(self, stamp_us: int) -> "dialect.MAVLink_message":
        """Return a GPS2_RAW."""
        height, *accuracies, yaw = self._extension()
        return dialect.MAVLink_gps2_raw_message(stamp_us, *self._common(), 0, 0, yaw, height, *accuracies)

    def global_position(self, boot_ms: int) -> "dialect.MAVLink_message":
        """Return a GLOBAL_POSITION_INT."""
        east, north, up = np.rint(self.v_n * 100).astype(int).tolist()
        return dialect.MAVLink_global_position_int_message(boot_ms, *self._where(), 0, north, east, -up, UNKNOWN)

    def _common(self) -> tuple[int, ...]:
        if not self.has_fix:
            return 1, 0, 0, 0, UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, 3
        speed, course = UNKNOWN, UNKNOWN
        if self.autopilot.states_velocity:
            speed = round(float(np.hypot(self.v_n[0], self.v_n[1])) * 100)
            course = round(float(np.degrees(np.arctan2(self.v_n[0], self.v_n[1]))) % 360 * 100) % 36000
        return 3, *self._where(), 90, 140, speed, course, 14

    def _where(self) -> tuple[int, int, int]:
        altitude = self.height - self.autopilot.undulation_m
        return round(self.latitude * 1e7), round(self.longitude * 1e7), round(altitude * 1e3)

    def _extension(self) -> tuple[int, ...]:
        std, speed_std = self.autopilot.position_std_m, self.autopilot.velocity_std_m_s
        if not (self.has_fix and self.autopilot.states_accuracy and std > 0):
            return (0,) * 6
        accuracies = round(std * 1e3), round(std * UP_TO_LEVEL * 1e3), round(speed_std * 1e3), 0
        return (round(self.height * 1e3), *accuracies, 0)


class SimulatedReceiver:
    """A receiver at a truth's site, or on a track from there; times [s] must not go back by much."""

    def __init__(
        self, truth: Truth, autopilot: AutopilotTruth, track: VehicleTrack | None, seed: int | None
    ) -> None:
        self._truth, self._autopilot, self._track = truth, autopilot, track
        self._rng = np.random.default_rng([seed or 0, 0x6E55])
        self._std = 0.0 if seed is None else autopilot.position_std_m
        self._velocity_std = 0.0 if seed is None else autopilot.velocity_std_m_s
        self._error = self._std * self._rng.standard_normal(3)
        self._at = 0.0

    def look(self, t: float, jump_m: float, *, has_fix: bool) -> SimulatedFix:
        """Return what it sees at true time ``t`` [s], ``jump_m`` east of where it is."""
        truth, zero = self._truth, np.zeros(3)
        place = self._track.position(t) if self._track else zero
        velocity = self._track.velocity(t) if self._track else zero
        east, north, up = place + self._drawn(t) * (1, 1, UP_TO_LEVEL) + (jump_m, 0, 0)
        latitude = np.radians(truth.latitude_deg)
        curve = 1 - ECCENTRICITY2 * np.sin(latitude) ** 2
        meridian, normal = AXIS * (1 - ECCENTRICITY2) / curve**1.5, AXIS / np.sqrt(curve)
        return SimulatedFix(
            latitude=truth.latitude_deg + float(np.degrees(north / meridian)),
            longitude=_wrapped(truth.longitude_deg + float(np.degrees(east / (normal * np.cos(latitude))))),
            height=truth.height_m + up,
            v_n=velocity + self._velocity_std * self._rng.standard_normal(3),
            has_fix=has_fix,
            autopilot=self._autopilot,
        )

    def _drawn(self, t: float) -> FloatArray:
        keep = float(np.exp(-max(t - self._at, 0.0) / CORRELATION_S))
        self._at = max(t, self._at)
        self._error = keep * self._error + self._std * np.sqrt(1 - keep**2) * self._rng.standard_normal(3)
        return self._error


def _wrapped(longitude_deg: float) -> float:
    """Return a longitude from -180 up to 180 deg, as receivers count it across the date line."""
    return (longitude_deg + 180.0) % 360.0 - 180.0


SET_MESSAGE_INTERVAL = 511
ACCEPTED, DENIED, UNSUPPORTED = 0, 2, 3
STREAMS = {
    1: (mavlink.HIGHRES_IMU,),
    2: (mavlink.GPS_RAW_INT, mavlink.GPS2_RAW),
    6: (mavlink.GLOBAL_POSITION_INT,),
    11: (mavlink.VFR_HUD,),
    12: (mavlink.SYSTEM_TIME,),
}
SENDS = tuple(number for numbers in STREAMS.values() for number in numbers)
MAX_BEHIND_S = 1.0  # messages older than this are not made up for
NEVER = float("inf")


class Autopilot:
    """Call `hear` with what came and `due` with the true time [s]; bytes come out."""

    def __init__(
        self,
        truth: Truth,
        autopilot: AutopilotTruth | None = None,
        faults: Sequence[TimedFault] = (),
        track: VehicleTrack | None = None,
        seed: int | None = 1,
    ) -> None:
        self.truth = autopilot or AutopilotTruth()
        self.faults = faults
        self._receiver = SimulatedReceiver(truth, self.truth, track, seed)
        self._rng = np.random.default_rng([seed or 0, 0xA9])
        self._mav = dialect.MAVLink(None, srcSystem=self.truth.system, srcComponent=self.truth.component)
        self._mav.robust_parsing = True
        if self.truth.key:
            self._mav.signing.secret_key = self.truth.key
            self._mav.signing.timestamp = signing_time()
        self._booted = 0.0  # true time of the last boot
        self._sent: list[bytes] = []
        self._held = b""
        self._restart(0.0)
        self.commands: list[tuple[int, float, int]] = []  # message, interval [us], result

    def hear(self, data: bytes, now: float) -> bytes:
        """Take what came and return what is answered at once."""
        out = list[bytes]()
        for message in self._mav.parse_buffer(data) or ():
            match message.get_type():
                case "COMMAND_LONG" if self._active(now, "deaf"):
                    pass
                case "COMMAND_LONG" if message.target_system in {0, self.truth.system}:
                    out.append(self._execute(message, now))
                case "REQUEST_DATA_STREAM" if message.target_system in {0, self.truth.system}:
                    rate = message.req_message_rate * message.start_stop
                    for number in STREAMS.get(message.req_stream_id, SENDS if not message.req_stream_id else ()):
                        self._set_interval(number, 1 / rate if rate else NEVER, now)
        return b"".join(out)

    @property
    def next_due(self) -> float:
        """True time [s] of the next message."""
        return min(self._next.values())

    def due(self, now: float) -> bytes:
        """Return all that is sent up to the true time ``now`` [s]."""
        if any(fault.at_s > self._booted for fault in self._active(now, "reboot")):
            self._booted = now
            self._restart(now)
        out = list[bytes]()
        for number, at in sorted(self._next.items(), key=lambda item: item[1]):
            interval = self._interval[number]
            at = max(at, now - MAX_BEHIND_S)
            while at <= now:
                out += self._spoilt(self._message(number, at), at)
                at += interval
            self._next[number] = at
        held, self._held = self._held + b"".join(out), b""
        if self._active(now, "backlog"):
            held, self._held = b"", held
        return held

    def _restart(self, now: float) -> None:
        self._mav.seq = 0
        self._interval = dict.fromkeys(SENDS, 1 / self.truth.default_hz if self.truth.default_hz else NEVER)
        self._interval[mavlink.HEARTBEAT] = 1.0
        self._next = {number: now if every < NEVER else NEVER for number, every in self._interval.items()}

    def _execute(self, message: "dialect.MAVLink_message", now: float) -> bytes:
        result = UNSUPPORTED
        if message.command == SET_MESSAGE_INTERVAL and self.truth.knows_intervals:
            number, interval = int(message.param1), message.param2
            known = number in SENDS and number not in self.truth.denies
            result = ACCEPTED if known and (interval <= 0 or interval >= 1e6 / self.truth.most_hz) else DENIED
            if result == ACCEPTED:
                seconds = interval / 1e6 if interval > 0 else 1 / self.truth.default_hz if not interval else NEVER
                self._set_interval(number, seconds, now)
            self.commands.append((number, interval, result))
        answer = dialect.MAVLink_command_ack_message(message.command, result)
        return b"".join(self._spoilt(answer, now))

    def _set_interval(self, number: int, seconds: float, now: float) -> None:
        if not self.truth.obeys:
            return
        self._interval[number] = seconds
        self._next[number] = now + seconds if seconds < NEVER else NEVER

    def _active(self, now: float, kind: str) -> list[TimedFault]:
        return active(self.faults, now, kind)

    def _message(self, number: int, now: float) -> "dialect.MAVLink_message":
        if number == mavlink.HEARTBEAT:
            return dialect.MAVLink_heartbeat_message(2, dialect.MAV_AUTOPILOT_ARDUPILOTMEGA, 0, 0, 4, 3)
        boot = now - self._booted
        boot_ms = round(boot * 1e3) % 2**32  # a field of 32 bit: 49.7 days
        late = self.truth.latency_s + sum(fault.size for fault in self._active(now, "latency"))
        utc_off = self.truth.epoch_utc + sum(fault.size for fault in self._active(now, "time_jump"))
        if number == mavlink.SYSTEM_TIME:
            known = not self._active(now, "no_fix")
            unix = round((utc_off + now) * 1e6) if known else 0
            return dialect.MAVLink_system_time_message(unix, boot_ms)
        if number == mavlink.VFR_HUD:
            return dialect.MAVLink_vfr_hud_message(self.truth.airspeed_m_s, 0.0, 0, 0, 0.0, 0.0)
        if number == mavlink.HIGHRES_IMU:
            nothing = [0.0] * 12
            return dialect.MAVLink_highres_imu_message(
                round(boot * 1e6), *nothing, self.truth.temperature_c, 1 << 12
            )
        jump = sum(fault.size for fault in self._active(now, "jump"))
        seen = self._receiver.look(max(now - late, 0.0), jump, has_fix=not self._active(now, "no_fix"))
        if number == mavlink.GLOBAL_POSITION_INT:
            return seen.global_position(boot_ms)
        stamp = utc_off + now - late if self.truth.states_utc else max(boot - late, 1e-6)
        return (seen.gps2_raw if number == mavlink.GPS2_RAW else seen.gps_raw_int)(round(stamp * 1e6))

    def _spoilt(self, message: "dialect.MAVLink_message", now: float) -> list[bytes]:
        """Return the message as it goes over the line, after faults."""
        mav, truth = self._mav, self.truth
        for fault in self._active(now, "wrong_system"):
            mav.srcSystem = int(fault.size) or 77
        signing = mav.signing
        signing.sign_outgoing = bool(truth.key) and not self._active(now, "unsigned")
        signing.secret_key = truth.wrong_key if self._active(now, "wrong_key") else truth.key or None
        raw = bytes(message.pack(mav))
        mav.seq, mav.srcSystem, signing.secret_key = (mav.seq + 1) % 256, truth.system, truth.key or None
        if self._active(now, "outage"):
            return []
        if self._active(now, "bad_crc"):
            at = int(self._rng.integers(6, len(raw)))
            raw = raw[:at] + bytes([raw[at] ^ 1 << int(self._rng.integers(8))]) + raw[at + 1 :]
        if self._active(now, "noise"):
            return [self._rng.bytes(4 * len(raw))]
        if self._active(now, "half"):
            return [raw[: len(raw) // 2]]
        if self._active(now, "repeated"):
            return [raw, raw]
        self._sent = [*self._sent[-19:], raw]
        return [raw, self._sent[0]] if self._active(now, "replay") else [raw]


POLL_S = 0.002
IDLE_S = 0.02  # at most, where nothing is due: what is planted acts by then, what comes is heard at once


class SimulatedGnss(CompanionDevice):
    """An autopilot on a real transport while the ``with`` block lasts.

    Parameters
    ----------
    truth, autopilot, faults, track, seed
        What is simulated, see `Autopilot`.
    imu
        The device whose time it shares; without it, the host's, ``speed`` times as fast.
    transport, link, port, to
        ``udp`` (it listens on ``port``, or sends to ``to``), ``tcp`` on ``port``, or ``pty``; port 0: any.
    """

    def __init__(
        self,
        truth: Truth,
        autopilot: AutopilotTruth | None = None,
        faults: Iterable[TimedFault] = (),
        track: VehicleTrack | None = None,
        seed: int | None = 1,
        *,
        imu: SimulatedDevice | None = None,
        speed: float = 1.0,
        transport: str = "udp",
        link: Path | None = None,
        port: int = 0,
        to: tuple[str, int] | None = None,
    ) -> None:
        self._line = _line(transport, link, port, to)
        super().__init__("simulated autopilot", faults, imu, speed, self._line.plug, self._line.unplug)
        self.autopilot = Autopilot(truth, autopilot, self.faults, track, seed)
        self._answer = b""

    @property
    def url(self) -> str:
        """The URL by which a station opens it."""
        return f"mavlink:{self._line.address.replace('://', ':', 1)}"

    def _step(self, now: float, *, is_plugged: bool) -> None:
        out = self._answer + self.autopilot.due(now)
        if not is_plugged:
            self._stop.wait(POLL_S)
            return
        heard = self._line.exchange(out, self._idle_s(now))
        self._answer = self.autopilot.hear(heard, now) if heard else b""

    def _idle_s(self, now: float) -> float:
        """Return how long [s] nothing is due from true time ``now`` on."""
        pace = self._imu.speed if self._imu else self._speed
        if not pace:  # as fast as it is read: nobody knows when
            return POLL_S
        return min(max((self.autopilot.next_due - now) / pace, POLL_S), IDLE_S)


def _line(transport: str, link: Path | None, port: int, to: tuple[str, int] | None) -> PtyLine | TcpLine | UdpLine:
    match transport:
        case "pty":
            return PtyLine(link)
        case "tcp":
            return TcpLine(port=port)
        case "udp":
            return UdpLine(port=port, to=to)
    raise ValueError(f"transport {transport!r}: expected udp, tcp or pty")
