"""The heading of an odometry's frame from its track: how far that is turned against the track of GNSS.

Horizontal positions and velocities are complex numbers, East + i North. With ``q`` the odometry's and ``z``
GNSS's, both about their means, ``z = exp(i yaw) q`` gives ``yaw = arg sum conj(q) z``; so do velocities. Han 2022
aligns positions only. It waits for displacement, which is what makes the sigma small, and for nothing else.
Outliers are weighted down (Huber).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from procedures.arrays import FloatArray
from procedures.fusion.outer.pose_graph_terms import huber

Complex = NDArray[np.complex128]
MAX_TRACK_MISFIT = 4.0  # of the misfit above which the tracks are not the same motion
HUBER_LIMIT = 1.9  # of a whitened vector of two: 95 % efficient on clean fixes
CHI2_MEDIAN = 1.386  # of two degrees of freedom
HUBER_ITERATIONS = 8
TINY = 1e-12


@dataclass(frozen=True, slots=True)
class TrackYaw:
    """``yaw`` [rad], 1 sigma, ``spread`` [m] rms of the odometry's track about its mean.

    ``misfit`` is the median of the whitened residuals squared over what noise alone would give, of positions or of
    velocities, whichever fit worse.
    """

    yaw: float
    std: float
    spread: float
    misfit: float


def track_yaw(
    q: FloatArray, z: FloatArray, z_std: FloatArray, v: FloatArray, u: FloatArray, u_std: FloatArray, drift: float
) -> TrackYaw:
    """Return the yaw that turns the odometry's track onto GNSS's.

    Parameters
    ----------
    q, z : (n, 2), m
        Horizontal positions of odometry and GNSS at the same times; ``z_std`` (n,) is 1 sigma of each axis.
    v, u : (n, 2), m/s
        Their velocities, nan where there is none; ``u_std`` (n,) is 1 sigma of each axis of the difference.
    drift : m2
        Variance that the odometry's own drift adds at the end of the track.
    """
    track, fixed = _complex(q), _complex(z)
    ours, theirs = _complex(v), _complex(u)
    known = np.isfinite(ours * theirs)
    ours, theirs, u_weight = ours[known], theirs[known], 1 / u_std[known] ** 2
    given = 1 / (z_std**2 + drift)
    weight, v_weight = given, u_weight
    for _ in range(HUBER_ITERATIONS):
        local, fix = track - np.average(track, weights=weight), fixed - np.average(fixed, weights=weight)
        turned = np.sum(weight * np.conj(local) * fix) + np.sum(v_weight * np.conj(ours) * theirs)
        turn = np.exp(1j * np.angle(turned))
        off, v_off = np.abs(fix - local * turn) * np.sqrt(given), np.abs(theirs - ours * turn) * np.sqrt(u_weight)
        weight, v_weight = given * huber(off, HUBER_LIMIT), u_weight * huber(v_off, HUBER_LIMIT)
    power, v_power = float(np.sum(weight * np.abs(local) ** 2)), float(np.sum(v_weight * np.abs(ours) ** 2))
    spread = float(np.mean(np.abs(local) ** 2))
    # white noise averages out over the fixes; drift does not: it is one draw over the whole track
    systematic = min(drift / max(spread, TINY), 1 / max(v_power, TINY))
    misfit = max(float(np.median(part**2)) for part in (off, v_off) if len(part)) / CHI2_MEDIAN
    std = np.sqrt(max(misfit, 1.0) * (1 / max(power + v_power, TINY) + systematic))
    return TrackYaw(float(np.angle(turned)), float(std), float(np.sqrt(spread)), misfit)


def _complex(pairs: FloatArray) -> Complex:
    values: Complex = pairs[:, 0] + 1j * pairs[:, 1]
    return values
