"""One parameter of one unit over its calibrations: turn-on repeatability, control chart, drift and prediction.

Calibrations within `CLUSTER_DAYS` of a cluster's first one are a cluster: so close that ageing adds nothing, each
with the unit switched on again. With ``m_c`` the mean of cluster c,

    y_i = m_c + r_i + e_i,    e_i ~ N(0, s_i^2) known,    r_i ~ N(0, tau^2),
    Q(tau^2) = sum_c sum_i w_i (y_i - ybar_c)^2,  w_i = 1 / (s_i^2 + tau^2),  ybar_c weighted with w_i.

At the true tau, Q is chi-squared with n - c degrees of freedom. The estimate is where Q is that number (Mandel and
Paule, Anal. Chem. 42, 1194, 1970), the 95 % interval where Q is a 2.5 or 97.5 % quantile (Viechtbauer, Statist.
Med. 26, 37, 2007).

A control chart holds each calibration against those before it. The probability u_i of a value below y_i, given
calibrations 1 ... i-1 (`procedures.statistics.significance`), makes z_i = Phi^-1(u_i), standard normal and
independent of the earlier ones (Hawkins, Technometrics 29, 1987; Quesenberry, J. Quality Technology 23, 1991).

    individuals   |z_i| > L                                            NIST/SEMATECH e-Handbook 6.3.2
    EWMA          v_i = a z_i + (1 - a) v_{i-1},  v_0 = 0,  a = 0.2    6.3.2.4
                  |v_i| > L sqrt(a / (2 - a) (1 - (1 - a)^(2 i)))

The first sees a jump, the second a slow drift. Drift between calibrations:

    y_i = x(t_i) + r_i + e_i
    x(t + dt) = x(t) + b dt + w,    w ~ N(0, q^2 dt),    b ~ N(0, c^2) one number per unit

r ~ N(0, tau^2) is drawn at each turn-on, e ~ N(0, s_i^2) is the calibration's own error. A grid holds combinations
of tau, q and c, each weighed by the probability of the data (a Kalman filter, one step per calibration; the level
before the first is unknown: Harvey, Forecasting, Structural Time Series Models and the Kalman Filter, 1989, 2.3
and 3.4). Beforehand each decade of tau and c is as likely as the next; walks are favoured by
`WALK_PRIOR_EXPONENT`, for else a short series passes too often for scatter about a constant. Predictions are
mixtures over the grid. The calibration interval ends when the prediction's central 95 % first touches a limit
(ILAC-G24 / OIML D 10, 2007, 5).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri
from scipy.stats import chi2

from procedures.arrays import BoolArray, FloatArray, IntArray
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
    """The standard deviation from turn-on to turn-on."""

    std: float
    interval_95: tuple[float, float]
    turn_ons: int
    dof: int


def turn_on_repeatability(series: CalibrationSeries) -> Repeatability | None:
    """Return the repeatability, None where no two calibrations lie within `CLUSTER_DAYS`."""
    together = [(series.value[one], series.std[one]) for one in clusters(series.day) if len(one) > 1]
    runs = sum(len(values) for values, _ in together)
    if (dof := runs - len(together)) == 0:
        return None
    wanted = (float(dof), float(chi2.ppf(0.975, dof)), float(chi2.ppf(0.025, dof)))
    std, low, high = (float(np.sqrt(_variance(together, each))) for each in wanted)
    return Repeatability(std, (low, high), runs, dof)


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


GRID_LEVELS_PER_DECADE = 5  # levels of the grid, of each of tau, q and c
# The density of log q rises as q to this power; the least that covers walks: docs/how-to/history.md
WALK_PRIOR_EXPONENT = 0.8


@dataclass(frozen=True, slots=True, eq=False)
class NormalMixture:
    """Weighted normal distributions: ``mean`` and ``std`` (k,) with ``weight`` (k,), of sum 1."""

    weight: FloatArray
    mean: FloatArray
    std: FloatArray

    def below(self, value: float) -> float:
        """Return the probability to be below a value."""
        return float(self.weight @ ndtr((value - self.mean) / self.std))

    def above(self, value: float) -> float:
        """Return the probability to be above a value, exact where it is small."""
        return float(self.weight @ ndtr((self.mean - value) / self.std))

    def quantile(self, probability: float) -> float:
        """Return the value below which the probability lies."""
        each = self.mean + ndtri(probability) * self.std
        finest = 1e-3 * float(self.std.min())
        ends = float(each.min()) - finest, float(each.max()) + finest
        return float(brentq(lambda value: self.below(value) - probability, *ends, xtol=finest, rtol=1e-12))


@dataclass(frozen=True, slots=True, eq=False)
class ProcessHypotheses:
    """Combinations of ``turn_on`` [unit], ``walk`` [unit/sqrt(day)] and ``trend`` [unit/day], all (k,)."""

    turn_on: FloatArray
    walk: FloatArray
    trend: FloatArray


def hypothesis_grid(series: CalibrationSeries) -> ProcessHypotheses:
    """Return the grid for a series; walk and trend have the levels of turn-on scatter over the whole span."""
    scatter = tau_levels(series.value, series.std, GRID_LEVELS_PER_DECADE)
    span = max(float(series.day[-1] - series.day[0]), 1.0)
    grid = np.meshgrid(scatter, scatter / np.sqrt(span), scatter / span, indexing="ij")
    return ProcessHypotheses(*(np.ascontiguousarray(part.ravel()) for part in grid))


class ProcessFilter:
    """The state of every hypothesis after the calibrations taken in so far: level and trend with covariance."""

    def __init__(self, ways: ProcessHypotheses, day: float, value: float, std: float) -> None:
        """Begin at the first calibration; the level before it was unknown."""
        self.ways, self.day = ways, day
        self.log_weight = WALK_PRIOR_EXPONENT * np.log(ways.walk)
        self._level = np.full_like(self.log_weight, value)
        self._slope = np.zeros_like(self.log_weight)
        self._level_level = std**2 + ways.turn_on**2
        self._level_slope = np.zeros_like(self.log_weight)
        self._slope_slope = ways.trend**2

    def at(self, day: float) -> NormalMixture:
        """Return what the unit does once it is turned on at a later day, measured without error."""
        dt = day - self.day
        weight = np.exp(self.log_weight - self.log_weight.max())
        counts = _most_of(weight)
        variance = self._ahead(dt)[0] + self.ways.turn_on**2
        mean = self._level + self._slope * dt
        return NormalMixture(weight[counts] / weight[counts].sum(), mean[counts], np.sqrt(variance[counts]))

    def take(self, day: float, value: float, std: float) -> None:
        """Weigh the hypotheses by a calibration and bring their states up to it."""
        dt = day - self.day
        level_level, level_slope = self._ahead(dt)
        noise = self.ways.turn_on**2 + std**2
        variance = level_level + noise
        surprise = value - (self._level + self._slope * dt)
        self.log_weight -= 0.5 * (surprise**2 / variance + np.log(variance))
        self._level = self._level + self._slope * dt + level_level / variance * surprise
        self._slope = self._slope + level_slope / variance * surprise
        self._slope_slope = self._slope_slope - level_slope**2 / variance
        self._level_level, self._level_slope = level_level * noise / variance, level_slope * noise / variance
        self.day = day

    def _ahead(self, dt: float) -> tuple[FloatArray, FloatArray]:
        level_slope = self._level_slope + dt * self._slope_slope
        level_level = self._level_level + dt * (self._level_slope + level_slope) + self.ways.walk**2 * dt
        return level_level, level_slope


def _most_of(weight: FloatArray) -> IntArray:
    """Return the indices of the largest weights that make up all but a ten-thousandth: a tenth of the grid."""
    order = np.argsort(-weight)
    return order[: 1 + int(np.searchsorted(np.cumsum(weight[order]), (1 - 1e-4) * weight.sum()))]


def filtered(series: CalibrationSeries, ways: ProcessHypotheses) -> ProcessFilter:
    """Return the filter after all calibrations of a series."""
    found = ProcessFilter(ways, *(float(part[0]) for part in (series.day, series.value, series.std)))
    for day, value, std in zip(series.day[1:], series.value[1:], series.std[1:], strict=True):
        found.take(float(day), float(value), float(std))
    return found


MIN_CALIBRATIONS = 3  # calibrations: from two, a trend and a scatter cannot be separated at all
TAIL_PROBABILITY = 0.025
MAX_SPANS_AHEAD = 3.0  # times the span of the data: farther ahead nothing seen says how it walks


@dataclass(frozen=True, slots=True)
class PredictedValue:
    """The value at ``day``, its 95 % interval, and the probability to be outside the limits if there are any."""

    day: float
    value: float
    low_95: float
    high_95: float
    outside: float | None


@dataclass(frozen=True, slots=True, eq=False)
class Forecast:
    """All that can be stated about the days after the last calibration; ``low``, ``high`` None: no limit there."""

    filter: ProcessFilter
    low: float | None = None
    high: float | None = None

    def at(self, day: float) -> PredictedValue:
        """Return the prediction for a day not before the last calibration."""
        mixture = self.filter.at(day)
        ends = mixture.quantile(TAIL_PROBABILITY), mixture.quantile(1 - TAIL_PROBABILITY)
        outside = None if self.low is None and self.high is None else sum(self._tails(mixture))
        return PredictedValue(day, mixture.quantile(0.5), *ends, outside)

    def first_touch(self, days: Sequence[float]) -> float | None:
        """Return the first of increasing days at which the interval reaches a limit, None if it never does."""
        last = None
        for day in days:
            if self._touches(day):
                return day if last is None else self._between(last, day)
            last = day
        return None

    def _between(self, free: float, touching: float) -> float:
        while touching - free > 0.5:
            middle = 0.5 * (free + touching)
            free, touching = (free, middle) if self._touches(middle) else (middle, touching)
        return touching

    def _touches(self, day: float) -> bool:
        return any(tail >= TAIL_PROBABILITY for tail in self._tails(self.filter.at(day)))

    def _tails(self, mixture: NormalMixture) -> Iterator[float]:
        if self.low is not None:
            yield mixture.below(self.low)
        if self.high is not None:
            yield mixture.above(self.high)


def last_predictable_day(day: FloatArray) -> float | None:
    """Return the last day that calibrations at ``day`` (n,), rising, let predict.

    None with fewer than `MIN_CALIBRATIONS` clusters of turn-ons: those of one week say nothing of a year.
    """
    if len(clusters(day)) < MIN_CALIBRATIONS:
        return None
    return float(day[-1] + MAX_SPANS_AHEAD * (day[-1] - day[0]))


def forecast(series: CalibrationSeries, low: float | None = None, high: float | None = None) -> Forecast | None:
    """Return the forecast after the last calibration, None with fewer than `MIN_CALIBRATIONS`."""
    if len(series) < MIN_CALIBRATIONS:
        return None
    return Forecast(filtered(series, hypothesis_grid(series)), low, high)
