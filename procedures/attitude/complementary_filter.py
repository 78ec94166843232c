"""The complementary filter (You and Lee's mixing algorithm) over samples as they come, and over a whole log.

Its final bias is You and Lee (8): the error of phi_m tends to that of phi_a, whatever gains and gyro bias are.
"""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog, roll_pitch_of
from procedures.attitude.complementary_gains import PAPER_GAINS, ComplementaryGains
from procedures.attitude.complementary_kernels import (
    FORMS,
    MIXER,
    PRINTED,
    PRINTED_GNSS,
    PRINTED_RATE,
    VECTOR,
    MixerSettings,
)
from procedures.attitude.complementary_velocity_aids import (
    INITIAL_VELOCITY_VARIANCE,
    acceleration_by_rates,
    mix_log,
    take_velocity,
)
from procedures.units import STANDARD_GRAVITY

MIN_COSINE = 0.1


@dataclass(frozen=True, slots=True)
class FinalBias:
    """By how much roll and pitch [rad] will read too much if the motion goes on as it is, and 1 sigma of it.

    Sigma is nan where the sensors' own biases are not known.
    """

    roll: float
    pitch: float
    roll_std: float
    pitch_std: float


def final_bias(
    left_out: tuple[float, float], left_std: tuple[float, float], attitude: tuple[float, float], g: float
) -> FinalBias:
    """Return the final value at an ``attitude``, roll and pitch [rad].

    Parameters
    ----------
    left_out, left_std
        Forward and right parts of the acceleration that is not corrected, body axes, and 1 sigma of them
        with the accelerometers' biases in it [m/s2].
    g
        m/s2.
    """
    roll, pitch = attitude
    along = g * max(np.cos(pitch), MIN_COSINE)
    across = along * max(abs(np.cos(roll)), MIN_COSINE)
    return FinalBias(-left_out[1] / across, left_out[0] / along, left_std[1] / across, left_std[0] / along)


RATE_GATE = 2.5e-3  # rad/s: You and Lee, section 4
STEEP_PITCH = np.radians(80.0)  # pitch beyond which the Euler form says so


class ComplementaryFilter:
    """The complementary filter: samples in, the attitude out, no history kept.

    Of ``aid`` "none" and "airspeed" (forward speed with remembered angle of attack, while turning faster than
    ``gate`` [rad/s]) are on the gravity vector. The others are in Euler angles as You and Lee print them, for
    reproduction: they fail where pitch nears 90 deg. "paper-airspeed" is forward speed alone (10), and
    "paper-airspeed-rate" and "paper-gnss" are (9) with what the airspeed or a GNSS velocity changes by.
    "paper-filter" is the velocity filter (11)-(14), which begins with ``velocity_variance`` [m2/s2] and from the
    vertical velocity of level flight; in turns of more than a minute it diverges, since it takes the attitude for
    known (docs/explanation/attitude.md). The first sample's specific force is where the attitude begins. Over a
    gap the rates of the sample after it are taken for what went on.
    """

    def __init__(
        self, gains: ComplementaryGains = PAPER_GAINS, aid: str = "none", gate: float = RATE_GATE,
        g: float = STANDARD_GRAVITY, velocity_variance: float = INITIAL_VELOCITY_VARIANCE,
    ) -> None:  # fmt: skip
        self._settings = MixerSettings(gains.k1, gains.k2, gate, g, FORMS[aid])
        self._mixers = np.zeros(1, MIXER)
        self._mixers[0].covariance = velocity_variance * np.eye(3)
        self._t: float | None = None

    @property
    def is_printed(self) -> bool:
        """Whether it is in Euler angles."""
        return self._settings.form >= PRINTED

    @property
    def gyro_bias(self) -> FloatArray:
        """The gyro bias (3,) [rad/s] learned so far; in Euler angles it is one of the body only while level."""
        bias = np.asarray(-self._mixers["correction"][0], np.float64)
        if self.is_printed:
            bias[2] = 0.0
        return bias

    @property
    def attitude(self) -> tuple[float, float]:
        """Roll and pitch [rad] at the last sample."""
        mixer = self._mixers[0]
        if self.is_printed:
            return float(mixer.roll), float(mixer.pitch)
        roll, pitch = roll_pitch_of(np.asarray(mixer.down, np.float64))
        return float(roll), float(pitch)

    @property
    def is_turning(self) -> bool:
        """Whether the gate is open: it turns faster than the gyros' noise and bias would show by themselves."""
        return bool(np.linalg.norm(self._mixers[0].smooth_rate) > self._settings.gate)

    def final_bias(self, force_std: float = np.nan, gyro_std: float = np.nan) -> FinalBias | None:
        """Return the angle at which the filter settles if the motion goes on (8); None without a velocity.

        ``force_std`` [m/s2] and ``gyro_std`` [rad/s] are 1 sigma of the sensors' biases. The velocity is the
        aid's, with the vertical part of the remembered angle of attack, which grows with the load as lift does: as
        far as it may do otherwise it is in sigma. Below the gate a rate counts as none.
        """
        mixer, form = self._mixers[0], self._settings.form
        if form == VECTOR or not mixer.known:
            return None
        rate = np.asarray(mixer.smooth_rate, np.float64) * self.is_turning
        if form == PRINTED_GNSS:
            return self._final((0.0, 0.0), 0.0, force_std, gyro_std)
        u, attack = float(mixer.airspeed), float(mixer.attack)
        took = acceleration_by_rates(np.asarray(mixer.velocity, np.float64), rate)
        as_lift, as_is = (
            acceleration_by_rates(np.array([u, 0.0, u * np.tan(a)]), rate) for a in (attack * mixer.load, attack)
        )
        change = 0.0 if form == PRINTED_RATE else float(mixer.steady_rate)
        left = as_lift[0] - took[0] + change, as_lift[1] - took[1]
        return self._final(left, as_lift[0] - as_is[0], force_std, gyro_std)

    def _final(self, left: tuple[float, float], unsure: float, force_std: float, gyro_std: float) -> FinalBias:
        by_rate = float(self._mixers[0].velocity[0]) * gyro_std  # a yaw gyro's bias, times the speed: a bank
        std = float(np.hypot(force_std, unsure)), float(np.hypot(force_std, by_rate))
        return final_bias(left, std, self.attitude, self._settings.g)

    def run(self, log: AttitudeLog) -> FloatArray:
        """Take samples: the unit down vector (n, 3) in b of every row, or its roll and pitch (n, 2) [rad]."""
        level = level_velocity(log) if self._settings.form == PRINTED_GNSS else _along_x(log)
        out, dt, begun = np.empty((len(log.t), 2 if self.is_printed else 3)), log.intervals, 0
        if self._t is None:
            out[0], begun = self._begin(log.f_b[0], level[0]), 1
        else:
            dt[0] = log.t[0] - self._t
        samples = (each[begun:] for each in (dt, log.omega_b, log.f_b, level, out))
        mix_log(self._mixers, self._settings, *samples)
        self._t = float(log.t[-1])
        return out

    def _begin(self, f_b: FloatArray, level: FloatArray) -> FloatArray:
        mixer, down = self._mixers[0], start_down(f_b)
        take_velocity(self._mixers, 0.0, level)
        if not self.is_printed:
            mixer.down = down
            return down
        mixer.roll, mixer.pitch = np.arctan2(down[1], down[2]), np.arcsin(-down[0])
        mixer.velocity[0] = mixer.airspeed
        return np.array([mixer.roll, mixer.pitch])


def level_velocity(log: AttitudeLog) -> FloatArray:
    """Return a log's GNSS velocity (n, 3) [m/s] forward, right and down of the heading, nan where there is none.

    Where no heading stands with a velocity: its size, nan and its vertical part.
    """
    if log.velocity is None:
        return np.full((len(log.t), 3), np.nan)
    north, east, down = log.velocity.T
    heading = np.full(len(log.t), np.nan) if log.heading is None else log.heading
    cosine, sine = np.cos(heading), np.sin(heading)
    size = np.linalg.norm(log.velocity, axis=1)
    ahead = np.where(np.isnan(heading), size, north * cosine + east * sine)
    return np.stack([ahead, east * cosine - north * sine, down], axis=1)


def _along_x(log: AttitudeLog) -> FloatArray:
    """Return a log's airspeed as a velocity (n, 3) [m/s] along body x."""
    velocity = np.zeros((len(log.t), 3))
    if log.airspeed is not None:
        velocity[:, 0] = log.airspeed
    return velocity


def start_down(f_b: FloatArray) -> FloatArray:
    """Return the down vector (3,) of the specific force ``f_b`` (3,) [m/s2] at rest; level where there is none."""
    norm = float(np.linalg.norm(f_b))
    return -f_b / norm if norm > 1e-6 else np.array([0.0, 0.0, 1.0])
