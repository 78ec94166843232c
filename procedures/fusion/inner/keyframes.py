"""When the inner layer has its keyframes: at each fix, and often enough between them."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.fusion.fusion_records import GnssFixes, ImuSeries

SPACING = 0.05  # s between keyframes, at most
CLOSEST = 0.02  # s: an IMU factor wants several samples


@dataclass(frozen=True, slots=True, eq=False)
class Keyframes:
    """``t`` (n,) [s], and the index of the fix that each one stands at, -1 where none does."""

    t: FloatArray
    fix: IntArray


def keyframes(fixes: GnssFixes, imu: ImuSeries, first: float, spacing: float = SPACING) -> Keyframes:
    """Return keyframes from ``first`` [s] to the end of the IMU; fixes on the heels of another have none."""
    times, fix = [first], [-1]
    for i in np.flatnonzero((fixes.t >= first) & (fixes.t <= imu.t[-1])):
        t = float(fixes.t[i])
        if t == first:
            fix[0] = int(i)
        elif t - times[-1] >= CLOSEST:
            _fill(times, fix, t, spacing)
            times.append(t)
            fix.append(int(i))
    _fill(times, fix, float(imu.t[-1]), spacing)
    return Keyframes(np.array(times), np.array(fix, np.int64))


def _fill(times: list[float], fix: list[int], until: float, spacing: float) -> None:
    parts = int(np.ceil((until - times[-1]) / spacing - 0.5))  # half a spacing more is no gap
    between = np.linspace(times[-1], until, parts + 1)[1:-1] if parts > 1 else np.zeros(0)
    times.extend(between.tolist())
    fix.extend([-1] * len(between))
