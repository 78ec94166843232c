"""What a simulated receiver sees: the true place with a receiver's errors, as fields of MAVLink's messages.

The error of position is a first-order Gauss-Markov process (minutes long, as multipath and atmosphere are), that
of velocity white.
"""

from dataclasses import dataclass

import numpy as np
from pymavlink.dialects.v20 import all as dialect

from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import VehicleTrack
from procedures.arrays import FloatArray

CORRELATION_S = 60.0
UP_TO_LEVEL = 1.6  # vertical over horizontal sigma
AXIS, FLATTENING2 = 6_378_137.0, 6.69437999014e-3  # WGS 84, and its eccentricity squared
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
        curve = 1 - FLATTENING2 * np.sin(latitude) ** 2
        meridian, normal = AXIS * (1 - FLATTENING2) / curve**1.5, AXIS / np.sqrt(curve)
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
