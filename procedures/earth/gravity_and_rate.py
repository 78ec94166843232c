"""Gravity and Earth rate, East-North-Up."""

import numpy as np

from procedures.arrays import FloatArray

EARTH_RATE = 7.292115e-5  # rad/s, WGS 84


def normal_gravity(latitude: float, height: float = 0.0) -> float:
    """Return normal gravity [m/s2] at a latitude [rad] and ellipsoidal height [m].

    Somigliana's closed form on WGS 84 with the free-air series to second order in height
    (NIMA TR8350.2, third edition, eq. 4-1 and 4-3).
    """
    a, flattening, m = 6378137.0, 1 / 298.257223563, 0.00344978650684
    sin2 = np.sin(latitude) ** 2
    surface = 9.7803253359 * (1 + 0.00193185265241 * sin2) / np.sqrt(1 - 0.00669437999014 * sin2)
    factor = 1 - 2 / a * (1 + flattening + m - 2 * flattening * sin2) * height + 3 * height**2 / a**2
    return float(surface * factor)


def earth_rate_n(latitude: float) -> FloatArray:
    """Return the Earth's rotation rate (3,) [rad/s] in East-North-Up at a latitude [rad]."""
    return EARTH_RATE * np.array([0.0, np.cos(latitude), np.sin(latitude)])
