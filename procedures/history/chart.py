"""A control chart that needs no known mean and no known scatter: each calibration against those before it.

Null hypothesis: the unit has one value, turn-on scatter tau and the calibrations' own sigmas, tau unknown. The
probability u_i of a value below y_i, given calibrations 1 ... i-1, makes z_i = Phi^-1(u_i), standard normal and
independent of the earlier ones (Hawkins, Technometrics 29, 1987; Quesenberry, J. Quality Technology 23, 1991; here
with unequal sigmas: `procedures.statistics.small_sample_outlier`). From it

    individuals   |z_i| > L                                            NIST/SEMATECH e-Handbook 6.3.2
    EWMA          v_i = a z_i + (1 - a) v_{i-1},  v_0 = 0,  a = 0.2    6.3.2.4
                  |v_i| > L sqrt(a / (2 - a) (1 - (1 - a)^(2 i)))

The first sees a jump, the second a slow drift. L is chosen by how many parameters are looked at together, so that
a calibration of a steady unit raises an alarm on each chart with `FALSE_ALARM` at most.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from procedures.arrays import BoolArray, FloatArray
from procedures.history.series import Series
from procedures.statistics.small_sample_outlier import Sums, each, levels, tails

BEFORE = 2  # calibrations that a third is judged against
SMOOTHING = 0.2
FALSE_ALARM = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class Chart:
    """Normalised shifts ``z``, their moving average and its standard deviation, all (n - `BEFORE`,)."""

    z: FloatArray
    ewma: FloatArray
    ewma_std: FloatArray
    limit: float

    @property
    def alarms(self) -> BoolArray:
        """Which calibrations, (n - `BEFORE`,), leave the control limits on either chart."""
        found: BoolArray = (np.abs(self.z) > self.limit) | (np.abs(self.ewma) > self.limit * self.ewma_std)
        return found


def control_limit(parameters: int) -> float:
    """Return L for so many parameters watched together: each has `FALSE_ALARM` / parameters, two-sided."""
    return float(-ndtri(FALSE_ALARM / parameters / 2))


def control_chart(series: Series, limit: float) -> Chart | None:
    """Return the chart, from the third calibration on; None if there is no third."""
    if len(series) <= BEFORE:
        return None
    z = _shifts(series)
    steps = np.arange(1, len(z) + 1)
    ewma = np.empty_like(z)
    last = 0.0
    for i, one in enumerate(z):
        ewma[i] = last = SMOOTHING * one + (1 - SMOOTHING) * last
    std = np.sqrt(SMOOTHING / (2 - SMOOTHING) * (1 - (1 - SMOOTHING) ** (2 * steps)))
    return Chart(z, ewma, std, limit)


def _shifts(series: Series) -> FloatArray:
    value, std = series.value - np.median(series.value), series.std
    tau = levels(value, std)
    terms = each(tau, value, std)
    earlier = (
        np.cumsum(part, axis=1)[:, BEFORE - 1 : -1] for part in (terms.log, terms.one, terms.first, terms.second)
    )
    below, above = tails(Sums(*earlier), tau, value[BEFORE:], std[BEFORE:])
    tail = np.maximum(np.minimum(below, above), 1e-300)  # the smaller tail keeps its digits; z of 37 is far enough
    z: FloatArray = np.where(below < above, ndtri(tail), -ndtri(tail))
    return z
