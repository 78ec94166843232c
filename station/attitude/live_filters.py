"""One attitude filter or two on the same samples: the first is shown, with the readings of both.

The joint (Kalman) filter always runs: it says whether the unit rests, and where north is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import down_of, inclination
from procedures.attitude.filter_choice import JOINT, PAPER_GAINS, Gains
from station.attitude.live_complementary_filter import ComplementaryFilterTrack
from station.attitude.live_kalman_filter import NO_AID, AidValues, AttitudeEstimator, compile_filter
from station.attitude.live_readings import AttitudeReading, FilterReading
from station.calibrated.filter_settings import force_bias_std, gyro_bias_std
from station.calibrated.rates_and_forces import RatesAndForces


class LiveFilters:
    """The filters asked for, alongside a joint filter; ``calibration`` says the sigma of the sensors' biases."""

    def __init__(
        self, laws: Sequence[str], aid: str, joint: AttitudeEstimator, calibration: Mapping[str, Any] | None,
        gravity: float, gains: Gains | None = None,
    ) -> None:  # fmt: skip
        self._laws, self._aid, self._joint = tuple(laws), aid, joint
        stds = (np.nan, np.nan)
        if calibration is not None:
            stds = force_bias_std(calibration), gyro_bias_std(calibration)
        self._tracks = {
            law: ComplementaryFilterTrack(law, aid, gains or PAPER_GAINS, gravity, *stds)
            for law in self._laws
            if law != JOINT
        }

    def reset(self) -> None:
        """Take the next tick's time as one of another beginning."""
        self._joint.reset()
        for track in self._tracks.values():
            track.reset()

    def take(
        self, t: FloatArray, inputs: RatesAndForces, aiding: AidValues = NO_AID
    ) -> tuple[AttitudeReading, tuple[FilterReading, ...]] | None:
        """Take ends ``t`` (n,) [s] and inputs of a tick; None while aligning.

        The tuple is empty where only the joint filter was asked for.
        """
        found = self._joint.take(t, inputs, aiding)
        read = {law: track.take(t, inputs, aiding) for law, track in self._tracks.items()}
        if found is None:
            return None
        beside = [joint_filter_reading(found, self._aid) if law == JOINT else read[law] for law in self._laws]
        laws = tuple(law for law in beside if law is not None)
        if not self._tracks or len(laws) < len(self._laws):
            return found, ()
        return (found if laws[0].law == JOINT else self._read_by(laws[0], found)), laws

    def _read_by(self, law: FilterReading, found: AttitudeReading) -> AttitudeReading:
        """Return the reading with a filter's attitude in the place of the joint filter's; it has no sigma."""
        residual = float(np.degrees(inclination(-self._joint.smoothed_force, np.array(law.down))))
        return replace(found, roll=law.roll, pitch=law.pitch, bias=law.bias, sigma=float("nan"), residual=residual)


def compile_filters() -> None:
    """Compile all filters. The result is kept on the disk, so that only the first run takes a minute."""
    compile_filter()
    t: FloatArray = 0.01 * np.arange(300.0)
    still = RatesAndForces(np.zeros((300, 3)), np.tile([0.0, 0.0, -9.8], (300, 1)))
    ComplementaryFilterTrack("mixer", "none").take(t, still)


def joint_filter_reading(found: AttitudeReading, aid: str) -> FilterReading:
    """Return the joint filter's reading as a filter's."""
    d0, d1, d2 = down_of(np.radians(found.roll), np.radians(found.pitch)).tolist()
    return FilterReading(JOINT, f"Kalman filter, aid {aid}", found.roll, found.pitch, (d0, d1, d2), found.bias)
