"""One link's bytes to records: the fixes of one system, and what else it reports.

Fields of MAVLink's messages (common.xml) become a `GnssFix` in SI, None where the sender does not know them: DOP,
speed, course 65535; satellites 255; accuracies of 0 and 4294967295; a yaw of 0 (36000 is north); a height of
2147483647 mm; a height above the ellipsoid of 0 with accuracies of 0 (extension fields that were not filled).

GPS_RAW_INT is stamped with UTC or with the time since boot, as the sender likes; SYSTEM_TIME holds both (ArduPilot
issue 626). It is written the moment its boot time is read, so that its least lateness is the link's own delay.
"""

import math
from collections import Counter, deque
from dataclasses import dataclass
from typing import Any

from drivers.mavlink import frames as mavlink
from drivers.mavlink.frames import NAMES, READ, Frame, MavlinkFramer, SignatureCheck, fields
from procedures.gnss_records import AirData, Ambient, FixType, GnssFix, TimeMark

EPOCH_US = 10**15  # us; what is beyond is UTC (2001), what is below since boot (32 years)
REBOOT_NS = 10**9
BOOT_MODULUS_MS = 2**32  # of time_boot_ms: it restarts at 0 after 49.7 days
WRAPS_WITHIN_MS = 60_000  # of the last mark; a time that goes back after more is a restart
WINDOW_MARKS = 600  # marks: minutes, in which crystals drift apart by less than the link's jitter


class SenderClock:
    """Learns from SYSTEM_TIME marks; times in ns."""

    def __init__(self) -> None:
        self.reboots = 0
        self._utc_less_boot: int | None = None
        self._host_less_boot: deque[int] = deque(maxlen=WINDOW_MARKS)
        self._last_boot = 0

    def mark(self, host_ns: int, boot_ns: int, utc_ns: int | None) -> TimeMark:
        """Take a SYSTEM_TIME; ``utc_ns`` None while the sender does not know it."""
        if boot_ns < self._last_boot - REBOOT_NS:
            self.reboots += 1
            self._utc_less_boot = None
            self._host_less_boot.clear()
        self._last_boot = boot_ns
        if utc_ns is not None:
            self._utc_less_boot = utc_ns - boot_ns
        self._host_less_boot.append(host_ns - boot_ns)
        return TimeMark(host_ns, boot_ns, utc_ns)

    def since_boot_ns(self, boot_ms: int) -> int:
        """Return a ``time_boot_ms`` as a time since boot [ns] that goes on where the 32 bits wrap."""
        last = self._last_boot // 10**6
        later = (boot_ms - last + WRAPS_WITHIN_MS) % BOOT_MODULUS_MS - WRAPS_WITHIN_MS
        return (last + later if later < WRAPS_WITHIN_MS and last + later >= 0 else boot_ms) * 10**6

    def times(self, stamp_us: int) -> tuple[int | None, int | None]:
        """Return a stamp [us, either kind] as UTC and as time since boot [ns], each None where not known."""
        offset, stamp = self._utc_less_boot, stamp_us * 1000
        if stamp_us == 0:
            return None, None
        if stamp_us > EPOCH_US:
            return stamp, None if offset is None else stamp - offset
        return None if offset is None else stamp + offset, stamp

    def latency(self, host_ns: int, boot_ns: int | None) -> float | None:
        """Return how much later [s] than a SYSTEM_TIME a message of this boot time arrived."""
        if boot_ns is None or not self._host_less_boot:
            return None
        return (host_ns - boot_ns - min(self._host_less_boot)) / 1e9


U32, U16, U8 = 2**32 - 1, 65535, 255
I32 = 2**31 - 1
MAX_LATITUDE, MAX_LONGITUDE = 90 * 10**7, 180 * 10**7  # degE7
FULL_CIRCLE = 36_000  # cdeg
GPS_EPOCH = 315_964_800  # s since 1970
GPS_LEAP = 18  # s by which GPS time is ahead of UTC since 2017
WEEK = 604_800
FIRST_WEEK = 1930  # of 2017: from then on `GPS_LEAP` holds; less is a receiver that lost 1024 weeks or knows none
# GPS_INPUT_IGNORE_FLAGS
NO_ALT, NO_HDOP, NO_VDOP, NO_V_HORIZONTAL, NO_V_UP = 1, 2, 4, 8, 16
NO_STD_SPEED, NO_STD_H, NO_STD_V = 32, 64, 128


Times = tuple[int | None, int | None]  # UTC and the time since boot [ns]


def gnss_fix(frame: Frame, values: dict[str, Any], host_ns: int, clock: SenderClock) -> GnssFix:
    """Return the fix of a message of `_FIXES`."""
    number = values.get("fix_type", FixType.FIX_3D)
    claimed = FixType(number) if number <= max(FixType) else FixType.FIX_3D  # of a newer dialect: at least 3D
    no_place = _no_place(values) if claimed >= FixType.FIX_2D else None
    fix = FixType.NO_FIX if no_place else claimed
    (utc, boot), own = _FIXES[frame.number](values, clock, fix)
    there = fix >= FixType.FIX_2D
    return GnssFix(
        source=NAMES[frame.number],
        system=frame.system,
        host_ns=host_ns,
        fix=fix,
        utc_ns=utc,
        device_ns=boot,
        latency=clock.latency(host_ns, boot),
        latitude=_radians(values["lat"], 1e-7) if there else None,
        longitude=_radians(values["lon"], 1e-7) if there else None,
        no_place=no_place,
        **own,
    )


def _raw(values: dict[str, Any], clock: SenderClock, fix: FixType) -> tuple[Times, dict[str, Any]]:
    """Read a GPS_RAW_INT or GPS2_RAW."""
    there, is_3d = fix >= FixType.FIX_2D, fix >= FixType.FIX_3D
    filled = any(values[name] for name in ("h_acc", "v_acc", "vel_acc", "hdg_acc", "alt_ellipsoid"))
    return clock.times(values["time_usec"]), {
        "height": _height(values["alt_ellipsoid"]) if is_3d and filled else None,
        "altitude": _height(values["alt"]) if is_3d else None,
        "speed": None if values["vel"] == U16 or not there else values["vel"] / 100,
        "course": _direction(values["cog"]) if there else None,
        "heading": _direction(values["yaw"]) if values["yaw"] else None,
        "horizontal_std": _accuracy(values["h_acc"], 1e-3),
        "vertical_std": _accuracy(values["v_acc"], 1e-3),
        "speed_std": _accuracy(values["vel_acc"], 1e-3),
        "heading_std": _accuracy(values["hdg_acc"], math.radians(1e-5)),
        "hdop": None if values["eph"] in {0, U16} else values["eph"] / 100,
        "vdop": None if values["epv"] in {0, U16} else values["epv"] / 100,
        "satellites": _satellites(values),
    }


def _filtered(values: dict[str, Any], clock: SenderClock, fix: FixType) -> tuple[Times, dict[str, Any]]:
    """Read a GLOBAL_POSITION_INT: position, velocity (NED) and heading by the sender's own filter."""
    north, east, down = (values[name] / 100 for name in ("vx", "vy", "vz"))
    return clock.times(clock.since_boot_ns(values["time_boot_ms"]) // 1000), {
        "altitude": _height(values["alt"]) if fix >= FixType.FIX_3D else None,
        "speed": math.hypot(north, east),
        "course": math.atan2(east, north) % math.tau,
        "v_up": -down,
        "heading": _direction(values["hdg"]),
        "is_filtered": True,
    }


def _input(values: dict[str, Any], clock: SenderClock, fix: FixType) -> tuple[Times, dict[str, Any]]:
    """Read a GPS_INPUT, what a companion sends an autopilot; its flags say what to leave out."""
    flags, week = values["ignore_flags"], values["time_week"]
    utc, boot = clock.times(values["time_usec"])
    if week >= FIRST_WEEK and values["time_week_ms"] < WEEK * 1000:
        utc = (GPS_EPOCH + week * WEEK - GPS_LEAP) * 10**9 + values["time_week_ms"] * 10**6
    there, north, east = fix >= FixType.FIX_2D, values["vn"], values["ve"]
    moves = there and not flags & NO_V_HORIZONTAL
    return (utc, boot), {
        "altitude": _finite(values["alt"]) if fix >= FixType.FIX_3D and not flags & NO_ALT else None,
        "speed": _finite(math.hypot(north, east)) if moves else None,
        "course": _finite(math.atan2(east, north) % math.tau) if moves else None,
        "v_up": _finite(-values["vd"]) if there and not flags & NO_V_UP else None,
        "heading": _direction(values["yaw"]) if values["yaw"] else None,
        "satellites": _satellites(values),
    } | {
        name: None if flags & flag else _positive(values[field])
        for name, flag, field in (
            ("horizontal_std", NO_STD_H, "horiz_accuracy"), ("vertical_std", NO_STD_V, "vert_accuracy"),
            ("speed_std", NO_STD_SPEED, "speed_accuracy"), ("hdop", NO_HDOP, "hdop"), ("vdop", NO_VDOP, "vdop"),
        )
    }  # fmt: skip


def _no_place(values: dict[str, Any]) -> str | None:
    """Return why latitude and longitude are no place, None if they are one."""
    latitude, longitude = values["lat"], values["lon"]
    if not latitude and not longitude:
        return "latitude and longitude are exactly 0"
    if abs(latitude) > MAX_LATITUDE or abs(longitude) > MAX_LONGITUDE:
        return f"latitude {latitude / 1e7:.6g}, longitude {longitude / 1e7:.6g} deg are no place on Earth"
    if values.get("satellites_visible") == 0 and values["fix_type"] != FixType.STATIC:
        return "the fix is of 0 satellites"
    return None


def _radians(value: float, degrees: float) -> float:
    return math.radians(value * degrees)


def _satellites(values: dict[str, Any]) -> int | None:
    return None if values["satellites_visible"] == U8 else int(values["satellites_visible"])


def _direction(cdeg: int) -> float | None:
    return _radians(cdeg % FULL_CIRCLE, 0.01) if cdeg <= FULL_CIRCLE else None


def _height(mm: int) -> float | None:
    return mm / 1e3 if abs(mm) < I32 else None


def _accuracy(value: int, unit: float) -> float | None:
    return None if value == U32 else _positive(value, unit)


def _positive(value: float, unit: float = 1.0) -> float | None:
    return float(value * unit) if math.isfinite(value) and value > 0 else None


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


NO_AUTOPILOT = 8  # MAV_AUTOPILOT_INVALID: a ground station, a camera
_FIXES = {
    mavlink.GPS_RAW_INT: _raw,
    mavlink.GPS2_RAW: _raw,
    mavlink.GLOBAL_POSITION_INT: _filtered,
    mavlink.GPS_INPUT: _input,
}
TEMPERATURE = 1 << 12  # HIGHRES_IMU fields_updated


@dataclass(frozen=True, slots=True)
class CommandAnswer:
    """What a system answered to a command: MAV_RESULT, 0 accepted."""

    host_ns: int
    command: int
    result: int


Record = GnssFix | TimeMark | AirData | Ambient | CommandAnswer


class MavlinkDecoder:
    """Reads one system: the one asked for, else the first autopilot whose heartbeat is heard.

    ``systems`` counts frames by system, of everyone on the link; ``messages`` those of the system read, by name.
    """

    def __init__(self, system: int | None = None, signatures: SignatureCheck | None = None) -> None:
        self.framer = MavlinkFramer(signatures)
        self.clock = SenderClock()
        self.system = system
        self.component = 0
        self.systems: Counter[int] = Counter()
        self.messages: Counter[str] = Counter()
        self.heartbeats = 0

    def feed(self, data: bytes, host_ns: int) -> list[Record]:
        """Return what the bytes read at ``host_ns`` complete."""
        records = []
        for frame in self.framer.feed(data):
            self.systems[frame.system] += 1
            if frame.number in READ and (record := self._record(frame, host_ns)) is not None:
                records.append(record)
        return records

    def _record(self, frame: Frame, host_ns: int) -> Record | None:
        values = fields(frame)
        is_vehicle = frame.number == mavlink.HEARTBEAT and values["autopilot"] != NO_AUTOPILOT
        if is_vehicle and self.system in {None, frame.system}:
            self.system, self.component = frame.system, frame.component
            self.heartbeats += 1
        if frame.system != self.system:
            return None
        self.messages[NAMES[frame.number]] += 1
        if frame.number in _FIXES:
            return gnss_fix(frame, values, host_ns, self.clock)
        match frame.number:
            case mavlink.SYSTEM_TIME:
                utc = values["time_unix_usec"] * 1000 or None
                return self.clock.mark(host_ns, self.clock.since_boot_ns(values["time_boot_ms"]), utc)
            case mavlink.VFR_HUD:
                return AirData(host_ns, values["airspeed"]) if math.isfinite(values["airspeed"]) else None
            case mavlink.HIGHRES_IMU:
                known = values["fields_updated"] & TEMPERATURE and math.isfinite(values["temperature"])
                return Ambient(host_ns, values["temperature"]) if known else None
            case mavlink.COMMAND_ACK:
                return CommandAnswer(host_ns, values["command"], values["result"])
        return None
