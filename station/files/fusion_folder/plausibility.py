"""Units that cannot be, and clocks that do not meet."""

from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from station.errors import DataRefused

MEDIAN_FORCE_RANGE_M_S2 = (4.0, 25.0)  # m/s2 that the median of |f| keeps within, in any vehicle that comes back
MAX_RATE_RAD_S = 35.0  # rad/s: 2000 deg/s, the range of the IMUs that are located
MAX_FORCE_M_S2 = 5000.0  # m/s2, 500 g: beyond the range of any of them
MAX_DISTANCE_M = 1e7  # m, of a fix from the origin of its own level frame
# rad/s rms over a whole recording: half a turn a second, always; the wildest flights at hand have 0.9
MAX_RMS_RATE_RAD_S = 3.0


def refuse_units(imu: ImuSeries, file: Path) -> None:
    """Refuse specific force that holds no gravity, and rates that no vehicle turns at: those are g and deg/s."""
    peak = float(np.abs(imu.f_b).max())
    if peak > MAX_FORCE_M_S2:
        raise DataRefused(file, None, f"specific force up to {peak:.4g} m/s2", f"at most {MAX_FORCE_M_S2:g}")
    size = float(np.median(np.linalg.norm(imu.f_b, axis=1)))
    if not MEDIAN_FORCE_RANGE_M_S2[0] < size < MEDIAN_FORCE_RANGE_M_S2[1]:
        unit = "g" if 0.5 < size < 2 else "mg" if 500 < size < 2000 else "another unit than m/s2"
        raise DataRefused(
            file, None, f"a median |f| of {size:.4g}, as of {unit}", "specific force in m/s2, near 9.8"
        )
    rate = np.linalg.norm(np.clip(imu.omega_b, -1e9, 1e9), axis=1)
    rms, peak = float(np.sqrt(np.mean(rate**2))), float(rate.max())
    if peak > MAX_RATE_RAD_S or rms > MAX_RMS_RATE_RAD_S:
        found = f"rates of {rms:.3g} rms and up to {peak:.3g}, as of deg/s"
        raise DataRefused(
            file, None, found, f"angular rate in rad/s, below {MAX_RMS_RATE_RAD_S:g} rms and {MAX_RATE_RAD_S:g}"
        )


def refuse_far(fixes: GnssFixes, file: Path) -> None:
    """Refuse fixes that no level frame reaches: those are of an Earth-centred one, or in another unit."""
    far = float(np.abs(fixes.p_n).max())
    if far > MAX_DISTANCE_M:
        raise DataRefused(file, None, f"a position {far:.4g} m away", "metres East, North, Up of a place near by")


def refuse_apart(fixes: GnssFixes, t: FloatArray, what: str, file: Path) -> None:
    """Refuse fixes that do not overlap with the times ``t`` (n,) [s] of what moved between them, or of a truth."""
    if not (fixes.t[0] < t[-1] and fixes.t[-1] > t[0]):
        found = f"GNSS from {fixes.t[0]:.3f} to {fixes.t[-1]:.3f} s and {what} from {t[0]:.3f} to {t[-1]:.3f} s"
        raise DataRefused(file, None, found, "times of one clock that overlap")
