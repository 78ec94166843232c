"""The mixing law as an object that is given one sample at a time, and the same kernels over a whole log."""

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_gains import PAPER_GAINS, Gains
from procedures.attitude.complementary_kernels import EULER, VECTOR, mix_log, mix_vector
from procedures.attitude.complementary_velocity_aids import (
    AIDING,
    INITIAL_VELOCITY_VARIANCE,
    MixingLaw,
    mix_paper,
    mix_paper_log,
    mix_speed,
    mix_speed_log,
)  # fmt: skip
from procedures.attitude.forward_right_down import down_of
from procedures.units import STANDARD_GRAVITY

RATE_GATE = 2.5e-3  # rad/s: You and Lee, section 4
STEEP_PITCH = np.radians(80.0)  # pitch beyond which the Euler form says so


class ComplementaryFilter:
    """The mixing law on the gravity vector: one sample in, the down vector out, no history kept.

    ``aid`` is "none" or "airspeed" (forward speed with remembered angle of attack, while turning faster than
    ``gate`` [rad/s]). The first sample's specific force is where the down vector begins. Over a gap the rates of
    the sample after it are taken for what went on.
    """

    def __init__(self, gains: Gains = PAPER_GAINS, aid: str = "none", gate: float = RATE_GATE) -> None:
        self.aid, self._law = aid, MixingLaw(gains.k1, gains.k2, gate)
        self._states, self._aids = np.zeros(1, VECTOR), np.zeros(1, AIDING)
        self._t: float | None = None

    @property
    def down(self) -> FloatArray:
        """The down vector (3,) in body axes; zero before the first sample."""
        return np.asarray(self._states["down"][0].copy(), np.float64)

    @property
    def gyro_bias(self) -> FloatArray:
        """The gyro bias (3,) [rad/s] learned so far."""
        return np.asarray(-self._states["correction"][0], np.float64)

    def step(self, t: float, omega_b: FloatArray, f_b: FloatArray, airspeed: float = np.nan) -> FloatArray:
        """Take the sample that ends at ``t`` [s] and return the down vector (3,) there.

        ``omega_b`` (3,) [rad/s], ``f_b`` (3,) [m/s2]; ``airspeed`` [m/s], nan where there is none.
        """
        if self._t is None:
            self._states[0].down = start_down(f_b)
            self._t = t
            return self.down
        dt, self._t = t - self._t, t
        if self.aid == "airspeed":
            mix_speed(self._states, self._aids, self._law, dt, omega_b, f_b, airspeed)
        else:
            mix_vector(self._states, dt, omega_b, f_b, self._law.k1, self._law.k2)
        return self.down


class PrintedComplementaryFilter:
    """The law in Euler angles as You and Lee print it, for reproduction: it fails where pitch nears 90 deg.

    ``filtered`` asks for the velocity filter (11)-(14) instead of forward speed alone (10); in turns of more than
    a minute it diverges, since it takes the attitude for known (docs/attitude.md).
    """

    def __init__(
        self,
        gains: Gains = PAPER_GAINS,
        filtered: bool = False,
        gate: float = RATE_GATE,
        g: float = STANDARD_GRAVITY,
    ) -> None:
        self._law = MixingLaw(gains.k1, gains.k2, gate, g, filtered)
        self._states, self._aids = np.zeros(1, EULER), np.zeros(1, AIDING)
        self._aids[0].covariance = INITIAL_VELOCITY_VARIANCE * np.eye(3)
        self._t: float | None = None

    @property
    def roll_pitch(self) -> tuple[float, float]:
        """Roll and pitch [rad]."""
        return float(self._states["roll"][0]), float(self._states["pitch"][0])

    @property
    def gyro_bias(self) -> FloatArray:
        """What the integrals hold (3,) [rad/s], of roll and pitch: a bias of the body only while level."""
        return np.array([-self._states[0].roll_correction, -self._states[0].pitch_correction, 0.0])

    def step(self, t: float, omega_b: FloatArray, f_b: FloatArray, airspeed: float = np.nan) -> FloatArray:
        """Take the sample that ends at ``t`` [s] and return the down vector (3,) there.

        ``omega_b`` (3,) [rad/s], ``f_b`` (3,) [m/s2]; ``airspeed`` [m/s], nan where there is none.
        """
        if self._t is None:
            self._states[0].roll, self._states[0].pitch = _start_angles(f_b)
            self._aids[0].airspeed = self._aids[0].velocity[0] = 0.0 if np.isnan(airspeed) else airspeed
            self._t = t
        else:
            dt, self._t = t - self._t, t
            mix_paper(self._states, self._aids, self._law, dt, omega_b, f_b, airspeed)
        return down_of(*np.array(self.roll_pitch))


def mix(
    log: AttitudeLog, gains: Gains = PAPER_GAINS, aid: str = "none", gate: float = RATE_GATE
) -> tuple[FloatArray, ComplementaryFilter]:
    """Run the law over a log: the unit down vector (n, 3) in b of every row, and the filter as it ends."""
    mixer = ComplementaryFilter(gains, aid, gate)
    out, dt = np.empty((len(log.t), 3)), log.intervals
    out[0] = mixer.step(float(log.t[0]), log.omega_b[0], log.f_b[0])
    states, aids, law = mixer._states, mixer._aids, mixer._law  # noqa: SLF001  (its own module)
    samples = (dt[1:], log.omega_b[1:], log.f_b[1:])
    if aid == "airspeed":
        mix_speed_log(states, aids, law, *samples, _speed(log)[1:], out[1:])
    else:
        mix_log(states, *samples, law.k1, law.k2, out[1:])
    return out, mixer


def mix_as_printed(
    log: AttitudeLog, gains: Gains = PAPER_GAINS, filtered: bool = False, gate: float = RATE_GATE,
    g: float = STANDARD_GRAVITY,
) -> tuple[FloatArray, PrintedComplementaryFilter]:  # fmt: skip
    """Run the law in Euler angles over a log: roll and pitch (n, 2) [rad], and the filter as it ends."""
    mixer = PrintedComplementaryFilter(gains, filtered, gate, g)
    speed = _speed(log)
    mixer.step(float(log.t[0]), log.omega_b[0], log.f_b[0], float(speed[0]))
    out = np.empty((len(log.t), 2))
    out[0] = mixer.roll_pitch
    states, aids, law = mixer._states, mixer._aids, mixer._law  # noqa: SLF001
    mix_paper_log(states, aids, law, log.intervals[1:], log.omega_b[1:], log.f_b[1:], speed[1:], out[1:])
    return out, mixer


def start_down(f_b: FloatArray) -> FloatArray:
    """Return the down vector (3,) of the specific force ``f_b`` (3,) [m/s2] at rest; level where there is none."""
    norm = float(np.linalg.norm(f_b))
    return -f_b / norm if norm > 1e-6 else np.array([0.0, 0.0, 1.0])


def _start_angles(f_b: FloatArray) -> tuple[float, float]:
    down = start_down(f_b)
    return float(np.arctan2(down[1], down[2])), float(np.arcsin(-down[0]))


def _speed(log: AttitudeLog) -> FloatArray:
    return np.zeros(len(log.t)) if log.airspeed is None else log.airspeed
