"""A control chart that needs no known mean and no known scatter: each calibration against those before it.

Null hypothesis: the unit has one value, turn-on scatter tau and the calibrations' own sigmas, tau unknown. The
probability u_i of a value below y_i, given calibrations 1 ... i-1, makes z_i = Phi^-1(u_i), standard normal and
independent of the earlier ones (Hawkins, Technometrics 29, 1987; Quesenberry, J. Quality Technology 23, 1991; here
with unequal sigmas: `procedures.statistics.small_sample_outlier`). From it

    individuals   |z_i| > L                                            NIST/SEMATECH e-Handbook 6.3.2
    EWMA          v_i = a z_i + (1 - a) v_{i-1},  v_0 = 0,  a = 0.2    6.3.2.4
                  |v_i| > L sqrt(a / (2 - a) (1 - (1 - a)^(2 i)))

The first sees a jump, the second a slow drift. L is chosen by how many parameters are looked at together, so that
a calibration of a steady unit raises an alarm on each chart with `FALSE_ALARM_PROBABILITY` at most.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from procedures.arrays import BoolArray, FloatArray
from procedures.history.parameter_series import CalibrationSeries
from procedures.statistics.small_sample_outlier import TauSums, tail_probabilities, tau_levels, tau_terms

MIN_EARLIER = 2  # calibrations that a third is judged against
EWMA_WEIGHT = 0.2
FALSE_ALARM_PROBABILITY = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class ControlChart:
    """Normalised shifts ``z``, their moving average and its standard deviation, all (n - `MIN_EARLIER`,)."""

    z: FloatArray
    ewma: FloatArray
    ewma_std: FloatArray
    limit: float

    @property
    def alarms(self) -> BoolArray:
        """Which calibrations leave the control limits on either chart; shaped like ``z``."""
        return (np.abs(self.z) > self.limit) | (np.abs(self.ewma) > self.limit * self.ewma_std)


def control_limit(parameters: int) -> float:
    """Return L for so many parameters together: each has `FALSE_ALARM_PROBABILITY` / parameters, two-sided."""
    return float(-ndtri(FALSE_ALARM_PROBABILITY / parameters / 2))


def control_chart(series: CalibrationSeries, limit: float) -> ControlChart | None:
    """Return the chart, from the third calibration on; None if there is no third."""
    if len(series) <= MIN_EARLIER:
        return None
    z = _shifts(series)
    steps = np.arange(1, len(z) + 1)
    ewma = np.empty_like(z)
    last = 0.0
    for i, one in enumerate(z):
        ewma[i] = last = EWMA_WEIGHT * one + (1 - EWMA_WEIGHT) * last
    std = np.sqrt(EWMA_WEIGHT / (2 - EWMA_WEIGHT) * (1 - (1 - EWMA_WEIGHT) ** (2 * steps)))
    return ControlChart(z, ewma, std, limit)


def _shifts(series: CalibrationSeries) -> FloatArray:
    value, std = series.value - np.median(series.value), series.std
    tau = tau_levels(value, std)
    terms = tau_terms(tau, value, std)
    earlier = (np.cumsum(part, axis=1)[:, MIN_EARLIER - 1 : -1] for part in terms)
    below, above = tail_probabilities(TauSums(*earlier), tau, value[MIN_EARLIER:], std[MIN_EARLIER:])
    tail = np.maximum(np.minimum(below, above), 1e-300)  # the smaller tail keeps its digits; z of 37 is far enough
    return np.where(below < above, ndtri(tail), -ndtri(tail))
