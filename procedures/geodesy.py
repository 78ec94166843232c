"""WGS 84: gravity, Earth rate, and geodetic coordinates to and from a local East-North-Up frame.

By way of the Earth-centred frame: it holds at any distance (NIMA TR8350.2, third edition, 2.1 and 4.1).
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray

SEMI_MAJOR_AXIS_M = 6_378_137.0  # m
FLATTENING = 1 / 298.257223563
ECCENTRICITY_SQUARED = FLATTENING * (2 - FLATTENING)  # of the eccentricity
LATITUDE_ITERATIONS = 6  # each gains more than two digits near the ground


@dataclass(frozen=True, slots=True)
class LocalLevel:
    """A level frame's origin: ``latitude``, ``longitude`` [rad], ``height`` [m] above the ellipsoid."""

    latitude: float
    longitude: float
    height: float = 0.0

    def enu(self, latitude: float, longitude: float, height: float) -> FloatArray:
        """Return a place (3,) [m] East-North-Up of the origin."""
        moved: FloatArray = _earth_fixed(latitude, longitude, height) - _earth_fixed(*self._own)
        return self._C_ne @ moved

    def geodetic(self, enu: FloatArray) -> tuple[float, float, float]:
        """Return latitude, longitude [rad] and height [m] of a place ``enu`` (3,) [m] about the origin."""
        x, y, z = (_earth_fixed(*self._own) + self._C_ne.T @ enu).tolist()
        out = float(np.hypot(x, y))
        latitude = float(np.arctan2(z, out * (1 - ECCENTRICITY_SQUARED)))
        for _ in range(LATITUDE_ITERATIONS):
            latitude = float(np.arctan2(z + ECCENTRICITY_SQUARED * _normal(latitude) * np.sin(latitude), out))
        up = out * np.cos(latitude) + z * np.sin(latitude)
        return latitude, float(np.arctan2(y, x)), float(up - SEMI_MAJOR_AXIS_M**2 / _normal(latitude))

    @property
    def _own(self) -> tuple[float, float, float]:
        return self.latitude, self.longitude, self.height

    @property
    def _C_ne(self) -> FloatArray:
        sin_b, cos_b = np.sin(self.latitude), np.cos(self.latitude)
        sin_l, cos_l = np.sin(self.longitude), np.cos(self.longitude)
        return np.array([
            [-sin_l, cos_l, 0.0], [-sin_b * cos_l, -sin_b * sin_l, cos_b], [cos_b * cos_l, cos_b * sin_l, sin_b]
        ])  # fmt: skip


def _normal(latitude: float) -> float:
    """Return the radius of curvature across the meridian [m]."""
    return float(SEMI_MAJOR_AXIS_M / np.sqrt(1 - ECCENTRICITY_SQUARED * np.sin(latitude) ** 2))


def _earth_fixed(latitude: float, longitude: float, height: float) -> FloatArray:
    out = (_normal(latitude) + height) * np.cos(latitude)
    z = (_normal(latitude) * (1 - ECCENTRICITY_SQUARED) + height) * np.sin(latitude)
    return np.array([out * np.cos(longitude), out * np.sin(longitude), z])


EARTH_RATE = 7.292115e-5  # rad/s, WGS 84


def normal_gravity(latitude: float, height: float = 0.0) -> float:
    """Return normal gravity [m/s2] at a latitude [rad] and ellipsoidal height [m].

    Somigliana's closed form on WGS 84 with the free-air series to second order in height
    (NIMA TR8350.2, third edition, eq. 4-1 and 4-3).
    """
    a, m = SEMI_MAJOR_AXIS_M, 0.00344978650684
    sin2 = np.sin(latitude) ** 2
    surface = 9.7803253359 * (1 + 0.00193185265241 * sin2) / np.sqrt(1 - ECCENTRICITY_SQUARED * sin2)
    factor = 1 - 2 / a * (1 + FLATTENING + m - 2 * FLATTENING * sin2) * height + 3 * height**2 / a**2
    return float(surface * factor)


def earth_rate_n(latitude: float) -> FloatArray:
    """Return the Earth's rotation rate (3,) [rad/s] in East-North-Up at a latitude [rad]."""
    return EARTH_RATE * np.array([0.0, np.cos(latitude), np.sin(latitude)])
