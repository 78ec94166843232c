"""White noise of samples that also move slowly: the Hadamard deviation of neighbours, in the quietest seconds."""

import math

import numpy as np

from procedures.arrays import FloatArray

QUIETEST_QUANTILE = 0.05  # of the windows' variance that counts as the unit's own
# quanta^2: second differences of counts that step up and down by one, as they show as noise
COUNTING_VARIANCE = 4 / 6


def white_noise(samples: FloatArray, period: float, *, window_s: float = 1.0, quantum: float = 0.0) -> float:
    """Return the noise density of the worst axis [unit of the samples times sqrt(s)].

    From second differences, so that bias and slow motion do not count; 0 for less than a window of samples.

    Parameters
    ----------
    samples : (n, 3) float64, any unit, sensor axes
    period : s, between samples
    window_s : s, of which the quietest count; infinity takes all samples together
    quantum : what one count is, in the unit of the samples, where counting is to be taken off
    """
    rows = max(round(window_s / period), 8) if math.isfinite(window_s) else len(samples) - 2
    windows = (len(samples) - 2) // rows if rows > 0 else 0
    if windows < 1:
        return 0.0
    second = np.diff(samples, n=2, axis=0)[: windows * rows]
    variance = np.mean(second.reshape(windows, rows, 3) ** 2, axis=1) / 6
    quiet = float(np.quantile(variance, QUIETEST_QUANTILE, axis=0).max())
    return float(np.sqrt(max(quiet - COUNTING_VARIANCE * quantum**2, 0.0) * period))
