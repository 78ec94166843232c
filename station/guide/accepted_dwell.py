"""What an accepted dwell leaves for the ones after it: the count rates of both triads with their sigmas."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.campaign.plan_steps import Dwell
from procedures.counts.count_rate import RateEstimate, estimate_channels
from procedures.counts.sample_records import CountSeries
from procedures.frames import face_of


@dataclass(frozen=True, slots=True, eq=False)
class AcceptedDwell:
    """Count rates (3,) and 1 sigma (3,) [count/s], raw, of a dwell."""

    step: Dwell
    accel: FloatArray
    accel_std: FloatArray
    gyro: FloatArray
    gyro_std: FloatArray

    @property
    def position(self) -> int:
        """The position, 1..24."""
        return self.step.position

    @property
    def face(self) -> str:
        """The face that was up."""
        return face_of(self.position)


def accepted_dwell(step: Dwell, series: CountSeries, accel: Sequence[RateEstimate] | None = None) -> AcceptedDwell:
    """Estimate the rates of a dwell; ``accel`` are the accelerometers', where they are known already."""
    accel = triad_estimates(series.accel, series) if accel is None else accel
    gyro = triad_estimates(series.gyro, series)
    return AcceptedDwell(step, *rates_and_sigmas(accel), *rates_and_sigmas(gyro))


def rates_and_sigmas(found: Sequence[RateEstimate]) -> tuple[FloatArray, FloatArray]:
    """Return the rates (3,) and their sigmas (3,)."""
    return np.array([each.rate for each in found]), np.array([each.std for each in found])


def triad_estimates(samples: IntArray | None, series: CountSeries) -> list[RateEstimate]:
    """Estimate the three channels of a triad from counts, ``samples`` (n, 3)."""
    assert samples is not None, "the station's own recordings contain both triads"
    channels = [[samples[:, i]] for i in range(3)]
    return [found[0] for found in estimate_channels(channels, series.period, [series.starts], [series.t])]
