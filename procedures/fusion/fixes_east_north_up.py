"""Fixes of a receiver as an estimator takes them: level about the first, with a sigma each, one antenna only."""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.earth.geodesy import LocalLevel
from procedures.earth.gnss_records import UNSTATED_STD_M, FixType, GnssFix
from procedures.fusion.fusion_records import GnssFixes

UP_TO_LEVEL = 1.5  # of the sigma of height to that of place, where a receiver states one only
UNSTATED_SPEED_STD = 0.2  # m/s of each axis
SOURCES = ("GPS_RAW_INT", "GPS_INPUT", "GPS2_RAW")  # of several the first: another antenna stands elsewhere


def is_usable(fix: GnssFix) -> bool:
    """Whether a fix has a place in three dimensions that no filter of its sender has had a hand in."""
    return fix.has_position and fix.fix >= FixType.FIX_3D and not fix.is_filtered and _height(fix) is not None


def antenna(fixes: Sequence[GnssFix]) -> str:
    """Return the message whose fixes are to be used, empty where there is none."""
    seen = {fix.source for fix in fixes if is_usable(fix)}
    return next((source for source in SOURCES if source in seen), "")


def origin_at(fix: GnssFix) -> LocalLevel:
    """Return the level frame about a usable fix."""
    assert fix.latitude is not None
    assert fix.longitude is not None
    return LocalLevel(fix.latitude, fix.longitude, _height(fix) or 0.0)


def level_fixes(origin: LocalLevel, t: FloatArray, fixes: Sequence[GnssFix]) -> GnssFixes:
    """Return usable fixes, valid at times ``t`` (n,) [s] of the IMU's clock, in a level frame.

    Without a height above the ellipsoid all are above mean sea level; a receiver states both or one all along.
    The sigma is the same on each axis: the root mean square of the three.
    """
    n = len(fixes)
    p_n, v_n = np.full((n, 3), np.nan), np.full((n, 3), np.nan)
    for i, fix in enumerate(fixes):
        assert fix.latitude is not None
        assert fix.longitude is not None
        p_n[i] = origin.enu(fix.latitude, fix.longitude, _height(fix) or 0.0)
        if (level := fix.velocity_n) is not None:
            v_n[i] = *level, np.nan if fix.v_up is None else fix.v_up
    std = np.array([_position_std(fix) for fix in fixes], dtype=np.float64)
    speed_std = np.array([fix.speed_std or UNSTATED_SPEED_STD for fix in fixes], dtype=np.float64)
    return GnssFixes(t, p_n, v_n, np.full(n, np.nan), std, speed_std)


def _height(fix: GnssFix) -> float | None:
    return fix.altitude if fix.height is None else fix.height


def _position_std(fix: GnssFix) -> float:
    level = fix.horizontal_std or UNSTATED_STD_M
    up = fix.vertical_std or UP_TO_LEVEL * level
    return float(np.sqrt((2 * level**2 + up**2) / 3))
