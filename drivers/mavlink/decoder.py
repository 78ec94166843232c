"""One link's bytes to records: the fixes of one system, and what else it reports."""

import math
from collections import Counter
from dataclasses import dataclass

from drivers.mavlink import frames as mavlink
from drivers.mavlink.fixes import SenderClock, filtered_fix, input_fix, raw_fix
from drivers.mavlink.frames import NAMES, READ, Frame, MavlinkFramer, fields
from drivers.mavlink.signing import SignatureCheck
from procedures.earth.gnss_records import AirData, Ambient, GnssFix, TimeMark

NO_AUTOPILOT = 8  # MAV_AUTOPILOT_INVALID: a ground station, a camera
_FIXES = {
    mavlink.GPS_RAW_INT: raw_fix,
    mavlink.GPS2_RAW: raw_fix,
    mavlink.GLOBAL_POSITION_INT: filtered_fix,
    mavlink.GPS_INPUT: input_fix,
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
        if (made := _FIXES.get(frame.number)) is not None:
            return made(frame, values, host_ns, self.clock)
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
