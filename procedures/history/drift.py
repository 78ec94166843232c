"""How a parameter drifts between calibrations, and its predicted value at a later date.

    y_i = x(t_i) + r_i + e_i
    x(t + dt) = x(t) + b dt + w,    w ~ N(0, q^2 dt),    b ~ N(0, c^2) one number per unit

r ~ N(0, tau^2) is drawn at each turn-on, e ~ N(0, s_i^2) is the calibration's own error. Nobody knows tau, q and
c: a grid holds combinations of them, and each is weighed by the probability of the data (a Kalman filter, one step
per calibration; the level before the first is unknown). With few calibrations no combination may be trusted alone,
so predictions are mixtures over the grid. Beforehand each decade of tau and c is as likely as the next; walks are
favoured by `WALK_PRIOR_EXPONENT`, for else a short series passes too often for scatter about a constant.

Source: Harvey, Forecasting, Structural Time CalibrationSeries Models and the Kalman ProcessFilter, 1989, 2.3 and
3.4.

What a parameter will be at a later date, and when it may leave its limits.
The mixture of `procedures.history.drift` at that date: what the unit does once it is turned on then. Its
central 95 % is the prediction interval. The calibration interval that it supports ends when the interval first
touches a limit (ILAC-G24 / OIML D 10, 2007, 5: intervals from the history of the same instrument).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri

from procedures.arrays import FloatArray, IntArray
from procedures.history.repeatability import CalibrationSeries, clusters
from procedures.statistics.significance import tau_levels

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


MIN_CALIBRATIONS = 3  # calibrations: from two, a trend and a scatter cannot be told apart at all
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
    """All that can be said about the days after the last calibration; ``low``, ``high`` None: no limit there."""

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
