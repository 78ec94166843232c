"""A GNSS receiver over MAVLink as the monitor's aid: its velocity, or an autopilot's airspeed.

What a receiver says is merged with the IMU's samples by the moments at which both were read, so that a replay
gives the same to the last bit. A velocity counts at its own moment: what its message was late by, as the sender's
clock tells it (else `USUAL_LATENCY`), and what passed since it was read are handed on as its age. A receiver that
does not tell its vertical velocity is taken not to climb.
"""

import math
from collections.abc import Sequence

from procedures.earth.gnss_records import AirData, FixType, GnssFix
from station.files.mcap_files.fix_reader import Record
from station.live_attitude.joint_filter import NO_AID, AidValues

USUAL_LATENCY = 0.1  # s; of most receivers 0.1 to 0.2 s


SILENT_S = 10.0  # of the device, without a value of the aid
EXPECTED = {
    "airspeed-filter": ("no airspeed", "VFR_HUD with airspeed from an autopilot", "--aid gnss"),
    "gnss": ("no GNSS velocity", "GPS_RAW_INT with speed and course", "--aid none"),
}


class AidSilence:
    """Says once that an aid tells nothing; what it aids goes on without."""

    def __init__(self, aid: str) -> None:
        self._aid, self._since, self._is_stated = aid, math.nan, False

    def look(self, aiding: AidValues, t: float) -> str:
        """Take what the aid said until device time ``t`` [s]; return what is to be said, empty if nothing."""
        if self._aid not in EXPECTED or self._is_stated:
            return ""
        if math.isnan(self._since) or t < self._since or aiding is not NO_AID:
            self._since = t
        if t - self._since < SILENT_S:
            return ""
        self._is_stated = True
        found, expected, instead = EXPECTED[self._aid]
        return f"{found} for {SILENT_S:.0f} s, expected {expected}; check --gnss, or use {instead}"


def aiding_of(records: Sequence[Record], aid: str, host_ns: int) -> AidValues:
    """Return the newest of what ``aid`` is about among records until a moment [ns], nan where there is nothing."""
    if aid == "airspeed-filter":
        airs = [record for record in records if isinstance(record, AirData)]
        return AidValues(airspeed=airs[-1].airspeed) if airs else NO_AID
    if aid == "gnss":
        for record in reversed(records):
            if isinstance(record, GnssFix) and (velocity := _velocity(record)) is not None:
                latency = USUAL_LATENCY if record.latency is None else record.latency
                age = max((host_ns - record.host_ns) / 1e9 + latency, 0.0)
                heading = math.nan if record.heading is None else record.heading
                return AidValues(velocity=velocity, heading=heading, age=age)
    return NO_AID


def _velocity(fix: GnssFix) -> tuple[float, float, float] | None:
    """Return a fix's velocity north, east, down [m/s]; None where it has none, or is filtered by its sender."""
    horizontal = fix.velocity_n
    if horizontal is None or fix.fix < FixType.FIX_2D or fix.is_filtered:
        return None
    east, north = horizontal
    return north, east, -(fix.v_up or 0.0)
