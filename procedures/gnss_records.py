"""What a GNSS receiver says, however it was brought here: SI and radians, the unknown absent.

Sources fill a `GnssFix`; a `TimeMark` pairs the station's monotonic time with GNSS time. A position that a
navigation filter has already mixed with its IMU is a fix with ``is_filtered`` and is never averaged with the rest.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from procedures.arrays import FloatArray
from procedures.statistics.significance import robust_std

EARTH_RADIUS_M = 6_371_000.0  # m; only for the scatter of positions metres apart
CONSTANT_FIXES = 20  # alike to 1e-7 deg, a centimetre: no receiver that measures each of them
UNSTATED_STD_M = 5.0  # m; of a receiver that states no accuracy: a code position without corrections


class FixType(IntEnum):
    """How good a fix is; values and order as MAVLink's GPS_FIX_TYPE."""

    NO_GPS = 0
    NO_FIX = 1
    FIX_2D = 2
    FIX_3D = 3
    DGPS = 4
    RTK_FLOAT = 5
    RTK_FIXED = 6
    STATIC = 7
    PPP = 8


@dataclass(frozen=True, slots=True)
class GnssFix:
    """One position, velocity and time; None is unknown.

    ``host_ns`` [ns] is when its bytes were read, of the station's monotonic clock counted from the epoch;
    ``utc_ns`` [ns since 1970] the moment it is valid for, ``device_ns`` the same by the sender's own clock.
    ``latency`` [s] is how much later it arrived than a message that the same sender writes at once.
    ``latitude``, ``longitude`` [rad]; ``height`` [m] above the ellipsoid, ``altitude`` [m] above mean sea level;
    ``speed`` [m/s] and ``course`` [rad from true north, clockwise] over ground, ``v_up`` [m/s]; ``heading`` [rad]
    of a receiver with two antennas. Sigmas are 1 sigma: ``horizontal_std``, ``vertical_std`` [m], ``speed_std``
    [m/s], ``heading_std`` [rad]. ``source`` names the message, ``system`` its sender;
    ``no_place`` says why the position that it holds was not taken.
    """

    source: str
    system: int
    host_ns: int
    fix: FixType
    utc_ns: int | None = None
    device_ns: int | None = None
    latency: float | None = None
    latitude: float | None = None
    longitude: float | None = None
    height: float | None = None
    altitude: float | None = None
    speed: float | None = None
    course: float | None = None
    v_up: float | None = None
    heading: float | None = None
    horizontal_std: float | None = None
    vertical_std: float | None = None
    speed_std: float | None = None
    heading_std: float | None = None
    hdop: float | None = None
    vdop: float | None = None
    satellites: int | None = None
    is_filtered: bool = False
    no_place: str | None = None

    @property
    def has_position(self) -> bool:
        """Whether latitude and longitude can be used."""
        return self.fix >= FixType.FIX_2D and self.latitude is not None and self.longitude is not None

    @property
    def velocity_n(self) -> tuple[float, float] | None:
        """East and north velocity [m/s]; None where speed or course is unknown."""
        if self.speed is None or self.course is None:
            return None
        return self.speed * float(np.sin(self.course)), self.speed * float(np.cos(self.course))


@dataclass(frozen=True, slots=True)
class TimeMark:
    """One moment on three clocks [ns]: the station's, the sender's own and, where it knows it, UTC."""

    host_ns: int
    device_ns: int
    utc_ns: int | None


@dataclass(frozen=True, slots=True)
class AirData:
    """Airspeed [m/s] along the body's forward axis, and when it was read [ns]."""

    host_ns: int
    airspeed: float


@dataclass(frozen=True, slots=True)
class Ambient:
    """Temperature [degC] of the sender's IMU, and when it was read [ns]."""

    host_ns: int
    temperature: float


@dataclass(frozen=True, slots=True)
class AveragedSite:
    """Where a receiver at rest stands [rad, m], 1 sigma [m].

    ``height`` is above the ellipsoid where ``is_ellipsoidal``, else above mean sea level, None where unknown. The
    sigmas do not shrink with ``fixes``: the errors of one receiver's fixes stay the same for minutes.
    ``is_constant``: many fixes are alike to the last digit, as of a receiver that holds its position, or none.
    """

    latitude: float
    longitude: float
    height: float | None
    is_ellipsoidal: bool
    horizontal_std: float
    vertical_std: float | None
    fixes: int
    is_constant: bool = False


def averaged_site(fixes: Sequence[GnssFix]) -> AveragedSite | None:
    """Return the median position of the fixes that a receiver alone made; None where there is none.

    The median of each coordinate, so that a jump in a part of the fixes does not move it. The 1 sigma is the
    greater of what the receiver states and what the fixes scatter (robust, of one fix).
    """
    used = [fix for fix in fixes if fix.has_position and not fix.is_filtered]
    if not used:
        return None
    latitude, longitude = (_numbers(used, name) for name in ("latitude", "longitude"))
    there = longitude[0] + (longitude - longitude[0] + np.pi) % (2 * np.pi) - np.pi  # across the date line
    mean = float(np.median(latitude)), float(np.median(there))
    north, east = EARTH_RADIUS_M * (latitude - mean[0]), EARTH_RADIUS_M * np.cos(mean[0]) * (there - mean[1])
    solid = [fix for fix in used if fix.fix >= FixType.FIX_3D]
    is_ellipsoidal = any(fix.height is not None for fix in solid)
    heights = _numbers(solid, "height" if is_ellipsoidal else "altitude")
    return AveragedSite(
        latitude=mean[0],
        longitude=float((mean[1] + np.pi) % (2 * np.pi) - np.pi),
        height=float(np.median(heights)) if len(heights) else None,
        is_ellipsoidal=is_ellipsoidal,
        horizontal_std=_std(used, "horizontal_std", np.hypot(robust_std(north), robust_std(east))),
        vertical_std=_std(solid, "vertical_std", robust_std(heights)) if len(heights) else None,
        fixes=len(used),
        is_constant=len(used) >= CONSTANT_FIXES and not np.ptp(latitude) and not np.ptp(there),
    )


def _numbers(fixes: Sequence[GnssFix], name: str) -> FloatArray:
    return np.array([value for fix in fixes if (value := getattr(fix, name)) is not None], dtype=np.float64)


def _std(fixes: Sequence[GnssFix], name: str, spread: float) -> float:
    stated = _numbers(fixes, name)
    return max(float(np.median(stated)) if len(stated) else UNSTATED_STD_M, float(spread))
