"""From samples of a rate output to their mean with an honest sigma."""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.count_rate import RateEstimate

# Of a dwell: their scatter is known to 7 %, and they are long enough to average a filter out
MIN_DWELL_BLOCKS = 128


def estimate_rates(dwells: Sequence[FloatArray], period: float) -> list[RateEstimate]:
    """Estimate the mean of one channel in each of several ``dwells`` (n,) of samples, in any unit of rate.

    The white noise, shared by all dwells, is taken from the Allan variance of blocks, the longest of which every
    dwell still holds `MIN_DWELL_BLOCKS`: the samples of a filtered or drifting output are not independent, and
    those of a quantised integral cancel, so the scatter of single samples would promise too much or too little
    (NIST SP 1065, 5.2). It is at least what rounding to the output's own step leaves.
    """
    values = [np.asarray(dwell, dtype=np.float64) for dwell in dwells]
    scatter = np.sqrt(np.mean([_white(each, max(len(each) // MIN_DWELL_BLOCKS, 1)) ** 2 for each in values]))
    white = float(max(scatter, output_step(values) / np.sqrt(12 * min(len(each) for each in values))))
    return [_estimate(each, white, period) for each in values]


def _estimate(values: FloatArray, white: float, period: float) -> RateEstimate:
    n = len(values)
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


def output_step(values: Sequence[FloatArray]) -> float:
    """Return the smallest difference between two ``values`` (n,), in their unit; of one what a float tells."""
    levels = np.unique(np.concatenate([np.unique(each) for each in values]))
    if len(levels) > 1:
        return float(np.diff(levels).min())
    return float(np.spacing(max(abs(float(levels[0])), 1.0)))
