"""One parameter of one unit over its calibrations: turn-on repeatability and control chart.

Calibrations within `CLUSTER_DAYS` of a cluster's first one are a cluster: so close that ageing adds nothing, each
with the unit switched on again. With ``m_c`` the mean of cluster c,

    y_i = m_c + r_i + e_i,    e_i ~ N(0, s_i^2) known,    r_i ~ N(0, tau^2),
    Q(tau^2) = sum_c sum_i w_i (y_i - ybar_c)^2,  w_i = 1 / (s_i^2 + tau^2),  ybar_c weighted with w_i.

At the true tau, Q is chi-squared with n - c degrees of freedom and falls as tau grows. The estimate is where Q is
that number (Mandel and Paule, Anal. Chem. 42, 1194, 1970), the 95 % interval where Q is a 2.5 or 97.5 % quantile
(Viechtbauer, Statist. Med. 26, 37, 2007). The 1 sigma comes from the restricted likelihood's information on tau^2.

A control chart that needs no known mean and no known scatter: each calibration against those before it.
Null hypothesis: the unit has one value, turn-on scatter tau and the calibrations' own sigmas, tau unknown. The
probability u_i of a value below y_i, given calibrations 1 ... i-1, makes z_i = Phi^-1(u_i), standard normal and
independent of the earlier ones (Hawkins, Technometrics 29, 1987; Quesenberry, J. Quality Technology 23, 1991; here
with unequal sigmas: `procedures.statistics.significance`). From it

    individuals   |z_i| > L                                            NIST/SEMATECH e-Handbook 6.3.2
    EWMA          v_i = a z_i + (1 - a) v_{i-1},  v_0 = 0,  a = 0.2    6.3.2.4
                  |v_i| > L sqrt(a / (2 - a) (1 - (1 - a)^(2 i)))

The first sees a jump, the second a slow drift. L is chosen by how many parameters are looked at together, so that
a calibration of a steady unit raises an alarm on each chart with `FALSE_ALARM_PROBABILITY` at most.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtri
from scipy.stats import chi2

from procedures.arrays import BoolArray, FloatArray
from procedures.statistics.significance import TauSums, tail_probabilities, tau_levels, tau_terms


@dataclass(frozen=True, slots=True, eq=False)
class CalibrationSeries:
    """When each calibration was made [day], what it found and its own 1 sigma, all (n,); times do not decrease.

    Raises
    ------
    ValueError
        If shapes differ, something is not finite, a sigma is not positive or a time decreases.
    """

    day: FloatArray
    value: FloatArray
    std: FloatArray

    def __post_init__(self) -> None:
        if not self.day.shape == self.value.shape == self.std.shape == (len(self.day),):
            raise ValueError(f"shapes {self.day.shape}, {self.value.shape}, {self.std.shape}, expected one (n,)")
        if not all(np.isfinite(part).all() for part in (self.day, self.value, self.std)):
            raise ValueError("a time, value or sigma that is not finite, expected all finite")
        if (self.std <= 0).any() or (np.diff(self.day) < 0).any():
            raise ValueError("a sigma of 0 or less, or a time before the last, expected neither")

    def __len__(self) -> int:
        return len(self.day)


CLUSTER_DAYS = 7.0


@dataclass(frozen=True, slots=True)
class Repeatability:
    """The standard deviation tau from turn-on to turn-on; ``std`` is None where tau is 0: see the interval."""

    value: float
    std: float | None
    low_95: float
    high_95: float
    runs: int
    dof: int


def turn_on_repeatability(series: CalibrationSeries) -> Repeatability | None:
    """Return the repeatability, None where no two calibrations lie within `CLUSTER_DAYS`."""
    together = [(series.value[one], series.std[one]) for one in clusters(series.day) if len(one) > 1]
    runs = sum(len(values) for values, _ in together)
    if (dof := runs - len(together)) == 0:
        return None
    low, high = (_variance(together, float(chi2.ppf(q, dof))) for q in (0.975, 0.025))
    found = _variance(together, float(dof))
    value = float(np.sqrt(found))
    std = float(np.sqrt(2.0 / _information(together, found)) / (2.0 * value)) if value > 0 else None
    return Repeatability(value, std, float(np.sqrt(low)), float(np.sqrt(high)), runs, dof)


def clusters(day: FloatArray) -> list[list[int]]:
    """Return the indices of the calibrations of each cluster; ``day`` (n,) rises."""
    found = list[list[int]]()
    for i, at in enumerate(day):
        if found and at - day[found[-1][0]] <= CLUSTER_DAYS:
            found[-1].append(i)
        else:
            found.append([i])
    return found


def _excess(clusters: list[tuple[FloatArray, FloatArray]], variance: float) -> float:
    total = 0.0
    for value, std in clusters:
        weight = 1.0 / (std**2 + variance)
        total += float(weight @ (value - weight @ value / weight.sum()) ** 2)
    return total


def _variance(clusters: list[tuple[FloatArray, FloatArray]], wanted: float) -> float:
    """Return tau^2 at which Q is ``wanted``, 0 if Q is less even there."""
    if _excess(clusters, 0.0) <= wanted:
        return 0.0
    scatter = sum(float(((value - value.mean()) ** 2).sum()) for value, _ in clusters)
    return float(brentq(lambda v: _excess(clusters, v) - wanted, 0.0, 2.0 * scatter / wanted, rtol=1e-12))


def _information(clusters: list[tuple[FloatArray, FloatArray]], variance: float) -> float:
    """Return tr(P P), twice the information on tau^2; ``P = W - W 1 1' W / (1' W 1)`` cluster by cluster."""
    total = 0.0
    for _, std in clusters:
        weight = 1.0 / (std**2 + variance)
        one, two, three = (float((weight**power).sum()) for power in (1, 2, 3))
        total += two - 2.0 * three / one + (two / one) ** 2
    return total


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
