"""What a parameter will be at a later date, and when it may leave its limits.

The mixture of `procedures.history.drift_models` at that date: what the unit does once it is turned on then. Its
central 95 % is the prediction interval. The calibration interval that it supports ends when the interval first
touches a limit (ILAC-G24 / OIML D 10, 2007, 5: intervals from the history of the same instrument).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from procedures.arrays import FloatArray
from procedures.history.drift_models import NormalMixture, ProcessFilter, filtered, hypothesis_grid
from procedures.history.parameter_series import CalibrationSeries
from procedures.history.repeatability import clusters

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
