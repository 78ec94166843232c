"""Units with a known past and future: turn-on scatter, random walk and trend, independent of the solve."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.statistics.calibration_drift import CalibrationSeries


@dataclass(frozen=True)
class World:
    """Turn-on scatter, walk per sqrt(day), 1 sigma of the trend per day; a calibration's own sigma is about 1."""

    turn_on: float = 0.0
    walk: float = 0.0
    trend: float = 0.0

    def unit(
        self, n: int, rng: np.random.Generator, ahead: float = 365.0
    ) -> tuple[CalibrationSeries, float, float]:
        """Return n calibrations half a year apart on average, a day ``ahead`` and the truth on it."""
        day = np.append(np.sort(rng.uniform(0, 180.0 * n, n)), 0.0)
        day[:-1] -= day[0]
        day[-1] = day[-2] + ahead
        truth: FloatArray = self.trend * rng.standard_normal() * day + self.turn_on * rng.standard_normal(n + 1)
        truth[1:] += np.cumsum(self.walk * np.sqrt(np.diff(day)) * rng.standard_normal(n))
        std = rng.uniform(0.5, 2.0, n)
        value = truth[:-1] + std * rng.standard_normal(n)
        return CalibrationSeries(day[:-1], value + 1000.0, std), float(day[-1]), float(truth[-1]) + 1000.0


WORLDS = {
    "steady": World(),
    "turn-on scatter": World(turn_on=10.0),
    "random walk": World(walk=0.5),
    "walk, little noise": World(walk=5.0, turn_on=1.0),
    "trend": World(trend=0.05, turn_on=1.0),
    "all three": World(turn_on=3.0, walk=0.3, trend=0.02),
}
