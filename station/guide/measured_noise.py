"""The noise of a unit of which nothing is known, by what its first dwells scatter.

Two minutes at rest show white noise. The accelerometers' scale is what one g makes of the vertical one; that of
the gyroscopes follows from turns or dwells, else the rest is taken for the Earth's rate alone. What a bias wanders
by from step to step no rest shows: it is taken to be as much as two minutes of white noise.
"""

from collections.abc import Sequence

import numpy as np

from procedures.bench.dwell_length import WHITE_NOISE_FACTOR
from procedures.earth.geodesy import EARTH_RATE
from procedures.planning.step_information import UnitNoise
from procedures.units import RAD_PER_DEG
from station.guide.accepted_dwell import AcceptedDwell

NOISE_S = 120.0  # s at rest that show a unit's noise


def measured_noise(
    dwells: Sequence[tuple[AcceptedDwell, float]], gyro_k: float | None, *, counts: bool
) -> UnitNoise:
    """Return the noise that dwells show, each with its seconds.

    Parameters
    ----------
    dwells : at least one, with how long [s] each lasted
    gyro_k : count/rad, the gyroscopes' scale factor where it is known
    counts : whether the unit counts
    """
    one_g = max(float(np.max(np.abs(dwell.accel))) for dwell, _ in dwells)
    rest = float(np.linalg.norm(dwells[0][0].gyro))
    per_deg = (gyro_k or rest / EARTH_RATE) * RAD_PER_DEG
    accel, gyro = (
        np.sqrt(np.mean([getattr(dwell, name) ** 2 * seconds for dwell, seconds in dwells], axis=0))
        / WHITE_NOISE_FACTOR
        for name in ("accel_std", "gyro_std")
    )
    scales = (one_g, per_deg) if counts else (np.inf, np.inf)
    wander = float(np.sqrt(np.mean((gyro / per_deg) ** 2) / NOISE_S))
    return UnitNoise(accel / one_g, gyro / per_deg, np.full(3, scales[0]), np.full(3, scales[1]), wander)
