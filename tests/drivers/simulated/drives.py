"""Tracks to drive: out of a rest, round bends, to a rest, at velocities that an IMU can sample."""

import numpy as np

from drivers.simulated.vehicle_track import VehicleTrack

SETTING_OFF = 4.0  # s


def bends(seconds: float, still: float = 0.0, speed: float = 6.0) -> VehicleTrack:
    """Return a bent eight of some 40 m, ``still`` [s] at its beginning; slower at its ends."""
    t = np.arange(0.0, seconds + 0.05, 0.1)
    moved = np.clip(t - still, 0.0, None)
    s = np.where(moved < SETTING_OFF, moved**2 / 2 / SETTING_OFF, moved - SETTING_OFF / 2)
    a = speed * s / 40
    # it sets off to the north-east
    enu = np.stack([40 * np.sin(a), 25 * np.sin(1.7 * a), 0.5 * (1 - np.cos(0.3 * a))], axis=1)
    return VehicleTrack(t, enu)
