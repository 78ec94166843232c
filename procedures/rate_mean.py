"""From samples of a rate output to their mean with an honest sigma."""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.count_rate import RateEstimate

BLOCKS = 32  # fewest blocks whose scatter is trusted


def estimate_rates(
    dwells: Sequence[FloatArray], period: float, starts: Sequence[IntArray] | None = None
) -> list[RateEstimate]:
    """Estimate the mean of one channel in each of several dwells; ``starts`` is of no matter to a mean.

    The white noise is taken from the Allan variance of blocks, at one sample and at the longest block that
    still leaves `BLOCKS` of them, whichever implies more: filtered or drifting outputs have samples that are
    not independent, and the scatter of single samples would promise too much (NIST SP 1065, 5.2).
    """
    return [_estimate(np.asarray(dwell, dtype=np.float64), period) for dwell in dwells]


def _estimate(values: FloatArray, period: float) -> RateEstimate:
    n = len(values)
    white = max(_white(values, 1), _white(values, max(n // BLOCKS, 1)))
    x = (2 * np.arange(n) + 1) / n - 1
    polynomials = np.stack([x, (3 * x**2 - 1) / 2])
    slope, curvature = (polynomials @ (values - values.mean())) / np.sum(polynomials**2, axis=1)
    std, half = white / np.sqrt(n), n * period / 2
    return RateEstimate(
        rate=float(values.mean()), std=std, slope=float(slope) / half, slope_std=float(np.sqrt(3)) * std / half,
        curvature=3 * float(curvature) / half**2, curvature_std=3 * float(np.sqrt(5)) * std / half**2,
        noise=white * float(np.sqrt(period)), edges=n,
    )  # fmt: skip


def _white(values: FloatArray, length: int) -> float:
    """Return the white noise of a sample that the scatter of neighbouring blocks of ``length`` implies."""
    blocks = values[: len(values) // length * length].reshape(-1, length).mean(axis=1)
    return float(np.sqrt(length * np.mean(np.diff(blocks) ** 2) / 2)) if len(blocks) > 1 else 0.0
