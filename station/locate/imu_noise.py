"""Noise densities of a calibrated IMU: the Allan deviation of its own rest, and what its calibration says.

White noise is the random walk of the curve, or the most that the curve allows; of the counting, which is not
white, what it makes of a second. A bias' walk that the rest is too short to show is bounded by what a FOG's is.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.free_positions.rest_detection import second_means, whole_seconds
from procedures.fusion.fusion_records import ImuNoise, ImuSeries
from procedures.statistics.allan_deviation import noise_terms, overlapping_deviation
from procedures.statistics.white_noise import white_noise
from station.calibrated.filter_settings import FORCE_WALK, GYRO_BIAS_WALK, force_bias_std, gyro_bias_std

MIN_REST_S = 10.0  # of rest, for an Allan deviation
PATIENCE_S = 30.0
SAME_FORCE = 0.03  # m/s2 between the means of two seconds
SAME_RATE = np.radians(0.2)  # rad/s
MINUTE_S = 60.0
COUNTED_S = 1.0  # within which the counting's error is taken for white
MIN_GYRO_NOISE, MIN_FORCE_NOISE = 1e-7, 1e-4  # rad/s, m/s2 per root of a Hz: nothing is quieter on a vehicle
MIN_BIAS_WALK = 1e-10  # in either unit, below which the estimator's arithmetic ends


@dataclass(frozen=True, slots=True)
class Rest:
    """The samples from ``first`` to before ``last`` that stand still the longest, ``seconds`` of them."""

    first: int
    last: int
    seconds: float


def noise_once_known(
    imu: ImuSeries, period: float, calibration: Mapping[str, Any] | None, quantum: tuple[float, float]
) -> ImuNoise | None:
    """Return `noise_densities` after `MIN_REST_S` of rest, or for want of it after `PATIENCE_S`; None before."""
    rest, seconds = longest_rest(imu, quantum[1]), float(imu.t[-1] - imu.t[0])
    if rest.seconds < MIN_REST_S and seconds < PATIENCE_S:
        return None
    return noise_densities(imu, rest, period, calibration, quantum)


def longest_rest(imu: ImuSeries, quantum: float = 0.0) -> Rest:
    """Return the longest run of seconds of one mean; ``quantum`` [m/s2] is a count's worth of a second."""
    second = whole_seconds(imu.t)
    count = np.bincount(second)
    still = np.ones(len(count) - 1, dtype=bool)
    for values, allowed in ((imu.f_b, SAME_FORCE + 2 * quantum), (imu.omega_b, SAME_RATE)):
        steps = np.abs(np.diff(second_means(second, values), axis=0))
        still &= (steps.max(axis=1) < allowed) & (count[1:] > 0) & (count[:-1] > 0)
    edges = np.flatnonzero(np.diff(np.r_[False, still, False].astype(np.int8)))
    if not len(edges):
        return Rest(0, 0, 0.0)
    begins, ends = edges[::2], edges[1::2] + 1  # a run of n equal steps is n + 1 seconds
    longest = int(np.argmax(ends - begins))
    first, last = np.searchsorted(second, [begins[longest], ends[longest]]).tolist()
    return Rest(first, last, float(ends[longest] - begins[longest]))


def noise_densities(
    imu: ImuSeries, rest: Rest, period: float, calibration: Mapping[str, Any] | None,
    quantum: tuple[float, float] = (0.0, 0.0),
) -> ImuNoise:  # fmt: skip
    """Return the densities of a unit from its rest, where that is too short from its quietest seconds.

    ``quantum`` is a count's worth of angle [rad] and of velocity [m/s]. Without a ``calibration`` the biases are
    those of any IMU.
    """
    terms = _terms if rest.seconds >= MIN_REST_S else _quietest
    part = slice(rest.first, rest.last) if rest.seconds >= MIN_REST_S else slice(None)
    gyro, gyro_walk = terms(imu.omega_b[part], period, quantum[0])
    accel, accel_walk = terms(imu.f_b[part], period, quantum[1])
    biases: dict[str, float] = {}
    if calibration is not None:
        gyro_walk, accel_walk = min(gyro_walk, GYRO_BIAS_WALK), min(accel_walk, FORCE_WALK)
        biases = {"gyro_bias": gyro_bias_std(calibration), "accel_bias": force_bias_std(calibration)}
    return ImuNoise(
        max(gyro, MIN_GYRO_NOISE), max(gyro_walk, MIN_BIAS_WALK),
        max(accel, MIN_FORCE_NOISE), max(accel_walk, MIN_BIAS_WALK), **biases,
    )  # fmt: skip


def _terms(values: FloatArray, period: float, quantum: float) -> tuple[float, float]:
    """Return white noise and walk of the worst axis of samples (n, 3), of counting what it makes of a second."""
    white, walk = list[float](), list[float]()
    for axis in range(3):
        terms = noise_terms(overlapping_deviation(values[:, axis], period), quantum)
        white.append(terms["random_walk"].value or terms["random_walk"].high)
        walk.append(terms["rate_random_walk"].value or terms["rate_random_walk"].high)
    counting = quantum / np.sqrt(6 * COUNTED_S)  # of the difference of two counts, each off by less than one
    return float(np.hypot(max(white), counting)), max(walk)


def _quietest(values: FloatArray, period: float, quantum: float) -> tuple[float, float]:
    """Return white noise of the quietest seconds of a motion, and a walk as large in a minute."""
    white = white_noise(values, period)
    counting = quantum / np.sqrt(6 * COUNTED_S)
    return float(np.hypot(white, counting)), white / MINUTE_S
