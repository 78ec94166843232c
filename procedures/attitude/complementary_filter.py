"""The mixing law over samples as they come, and over a whole log."""

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_gains import PAPER_GAINS, Gains
from procedures.attitude.complementary_kernels import FORMS, MIXER, PRINTED, MixingLaw
from procedures.attitude.complementary_velocity_aids import INITIAL_VELOCITY_VARIANCE, mix_log
from procedures.units import STANDARD_GRAVITY

RATE_GATE = 2.5e-3  # rad/s: You and Lee, section 4
STEEP_PITCH = np.radians(80.0)  # pitch beyond which the Euler form says so


class ComplementaryFilter:
    """The mixing law: samples in, the attitude out, no history kept.

    Of ``aid`` "none" and "airspeed" (forward speed with remembered angle of attack, while turning faster than
    ``gate`` [rad/s]) are on the gravity vector. The others are in Euler angles as You and Lee print them, for
    reproduction: they fail where pitch nears 90 deg. "paper-airspeed" is forward speed alone (10), "paper-filter"
    the velocity filter (11)-(14); in turns of more than a minute that diverges, since it takes the attitude for
    known (docs/attitude.md). The first sample's specific force is where the attitude begins. Over a gap the rates
    of the sample after it are taken for what went on.
    """

    def __init__(
        self, gains: Gains = PAPER_GAINS, aid: str = "none", gate: float = RATE_GATE, g: float = STANDARD_GRAVITY
    ) -> None:
        self._law = MixingLaw(gains.k1, gains.k2, gate, g, FORMS[aid])
        self._mixers = np.zeros(1, MIXER)
        self._mixers[0].covariance = INITIAL_VELOCITY_VARIANCE * np.eye(3)
        self._t: float | None = None

    @property
    def is_printed(self) -> bool:
        """Whether it is in Euler angles."""
        return self._law.form >= PRINTED

    @property
    def gyro_bias(self) -> FloatArray:
        """The gyro bias (3,) [rad/s] learned so far; in Euler angles it is one of the body only while level."""
        bias = np.asarray(-self._mixers["correction"][0], np.float64)
        if self.is_printed:
            bias[2] = 0.0
        return bias

    def run(self, log: AttitudeLog) -> FloatArray:
        """Take samples: the unit down vector (n, 3) in b of every row, or its roll and pitch (n, 2) [rad]."""
        speed = np.zeros(len(log.t)) if log.airspeed is None else log.airspeed
        out, dt, begun = np.empty((len(log.t), 2 if self.is_printed else 3)), log.intervals, 0
        if self._t is None:
            out[0], begun = self._begin(log.f_b[0], float(speed[0])), 1
        else:
            dt[0] = log.t[0] - self._t
        samples = (each[begun:] for each in (dt, log.omega_b, log.f_b, speed, out))
        mix_log(self._mixers, self._law, *samples)
        self._t = float(log.t[-1])
        return out

    def _begin(self, f_b: FloatArray, speed: float) -> FloatArray:
        mixer, down = self._mixers[0], start_down(f_b)
        if not self.is_printed:
            mixer.down = down
            return down
        mixer.roll, mixer.pitch = np.arctan2(down[1], down[2]), np.arcsin(-down[0])
        mixer.airspeed = mixer.velocity[0] = 0.0 if np.isnan(speed) else speed
        return np.array([mixer.roll, mixer.pitch])


def start_down(f_b: FloatArray) -> FloatArray:
    """Return the down vector (3,) of the specific force ``f_b`` (3,) [m/s2] at rest; level where there is none."""
    norm = float(np.linalg.norm(f_b))
    return -f_b / norm if norm > 1e-6 else np.array([0.0, 0.0, 1.0])
