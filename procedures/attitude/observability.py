"""Observability of the velocity filter along a log: You and Lee (13), evaluated instead of assumed."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog

SMOOTH_S = 1.0


@dataclass(frozen=True, slots=True)
class Observability:
    """Over the rows at which the filter ran (``open_s`` seconds of the log).

    ``determinant_rms`` [rad3/s3] of (13); ``rank_3`` is the share of those rows at which it stands above what
    rates of the gate's size would give. Where it does not, velocity along the turn axis is dead reckoning.
    """

    open_s: float
    determinant_rms: float
    rank_3: float


def determinant(rate: FloatArray, slope: FloatArray) -> FloatArray:
    """Return the determinant (n,) of (13) for ``rate`` (n, 3) [rad/s] and its derivative ``slope`` (n, 3).

    It is ``p (q^2 + r^2) + q dr/dt - r dq/dt``.
    """
    p, q, r = np.moveaxis(rate, -1, 0)
    found: FloatArray = p * (q * q + r * r) + q * slope[..., 2] - r * slope[..., 1]
    return found


def observability(log: AttitudeLog, gate: float) -> Observability:
    """Evaluate (13) along a log, on rates averaged over a second, where they exceed the gate [rad/s]."""
    rows = max(round(SMOOTH_S / log.nominal), 1)
    kernel = np.ones(rows) / rows
    rate = np.stack([np.convolve(log.omega_b[:, i], kernel, "same") for i in range(3)], axis=1)
    slope = np.gradient(rate, log.t, axis=0) if len(log.t) > 2 else np.zeros_like(rate)
    is_open = np.linalg.norm(rate, axis=1) > gate
    found = determinant(rate, slope)[is_open]
    if not len(found):
        return Observability(0.0, 0.0, 0.0)
    above = np.abs(found) > 2 * gate**3
    return Observability(
        float(log.intervals[is_open].sum()), float(np.sqrt(np.mean(found**2))), float(np.mean(above))
    )
