"""One law or two on the same samples: the first's reading is what is shown, beside it both and how they differ.

The joint filter always runs: it says whether the unit rests, and where north is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.complementary_gains import PAPER_GAINS, Gains
from procedures.attitude.forward_right_down import down_of, inclination
from procedures.attitude.laws import JOINT
from station.calibrated.filter_settings import force_bias_std, gyro_bias_std
from station.calibrated.rates_and_forces import RatesAndForces
from station.live_attitude.joint_filter import NO_AID, AidValues, AttitudeEstimator, compile_filter
from station.live_attitude.mixing_law import MixingLawTrack
from station.live_attitude.readings import AttitudeReading, LawReading


class SideBySide:
    """The laws asked for, beside a joint filter; ``calibration`` says the sigma of the sensors' biases."""

    def __init__(
        self, laws: Sequence[str], aid: str, joint: AttitudeEstimator, calibration: Mapping[str, Any] | None,
        gravity: float, gains: Gains | None = None,
    ) -> None:  # fmt: skip
        self._laws, self._aid, self._joint = tuple(laws), aid, joint
        stds = (np.nan, np.nan)
        if calibration is not None:
            stds = force_bias_std(calibration), gyro_bias_std(calibration)
        self._tracks = {
            law: MixingLawTrack(law, aid, gains or PAPER_GAINS, gravity, *stds)
            for law in self._laws
            if law != JOINT
        }

    def begin_anew(self) -> None:
        """Take the next tick's time as one of another beginning."""
        self._joint.begin_anew()
        for track in self._tracks.values():
            track.begin_anew()

    def take(
        self, t: FloatArray, inputs: RatesAndForces, aiding: AidValues = NO_AID
    ) -> tuple[AttitudeReading, tuple[LawReading, ...]] | None:
        """Take ends ``t`` (n,) [s] and inputs of a tick; None while aligning.

        The laws are none where the joint filter alone was asked for.
        """
        found = self._joint.take(t, inputs, aiding)
        read = {law: track.take(t, inputs, aiding) for law, track in self._tracks.items()}
        if found is None:
            return None
        beside = [joint_as_law(found, self._aid) if law == JOINT else read[law] for law in self._laws]
        laws = tuple(law for law in beside if law is not None)
        if not self._tracks or len(laws) < len(self._laws):
            return found, ()
        return (found if laws[0].law == JOINT else self._read_by(laws[0], found)), laws

    def _read_by(self, law: LawReading, found: AttitudeReading) -> AttitudeReading:
        """Return the reading with a law's attitude in the place of the joint filter's; it has no sigma."""
        residual = float(np.degrees(inclination(-self._joint.smoothed_force, np.array(law.down))))
        return replace(found, roll=law.roll, pitch=law.pitch, bias=law.bias, sigma=float("nan"), residual=residual)


def compile_laws() -> None:
    """Have all laws compiled: kept on the disk, so that only a first run of all takes its minute."""
    compile_filter()
    t: FloatArray = 0.01 * np.arange(300.0)
    still = RatesAndForces(np.zeros((300, 3)), np.tile([0.0, 0.0, -9.8], (300, 1)))
    MixingLawTrack("mixer", "none").take(t, still)


def joint_as_law(found: AttitudeReading, aid: str) -> LawReading:
    """Return the joint filter's reading as a law's."""
    d0, d1, d2 = down_of(np.radians(found.roll), np.radians(found.pitch)).tolist()
    return LawReading(JOINT, f"Kalman filter, aid {aid}", found.roll, found.pitch, (d0, d1, d2), found.bias)
