"""Has the unit settled, so that its bias drifts less over a pair of positions than a dwell's own noise.

``white`` is its count noise [count/sqrt(s)]: a dwell of T seconds shows a rate to ``white / sqrt(T)``, the limit
of the drift over ``pair_s``. The drift shows in the slope of the means of the last W seconds, of ``std = white
sqrt(12 / W^3)`` (half the limit takes ``W^3 = 48 T pair_s^2``), or in the temperature's rate times the bias's
sensitivity [count/s/K], regressed with a prior as wide as fibre-optic gyros are. Either is enough where the other
does not contradict it (docs/explanation/guiding.md).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray

MIN_MEANS, MIN_MEANS_CONSTANT_TEMPERATURE = 6, 8  # means; while the thermometer shows always the same
RATE_MEANS, COARSE_MEANS = 12, 60  # the last ones, which the temperature's rate is taken from
SENSITIVITY_BOUND_SIGMAS = 2.0  # sigmas by which a sensitivity may be larger than it was found to be
CLEAR_DRIFT_SIGMAS = 3.0  # sigmas
# Of the rate at rest, 1 sigma: 0.1 deg/h/K, where the Earth's 15 deg/h are at rest
GYRO_SENSITIVITY_STD_PER_K = 0.1 / 15
ACCEL_SENSITIVITY_STD_PER_K = 5e-5  # of gravity, 1 sigma
WARM_UP_K = 10.0  # a whole warm-up
TAU_SHARES_TRIED = np.geomspace(0.1, 3.0, 40)  # of the time seen, for the exponential


@dataclass(frozen=True, slots=True, eq=False)
class IntervalMeans:
    """Means over equal intervals that end at ``t`` (n,) [s].

    Rates (n, 3) and their 1 sigma (n, 3) in count/s, ``accel`` None where not recorded; ``temperature`` (n,) degC,
    nan where unknown.
    """

    t: FloatArray
    gyro: FloatArray
    gyro_std: FloatArray
    temperature: FloatArray
    accel: FloatArray | None = None
    accel_std: FloatArray | None = None

    @property
    def interval(self) -> float:
        """Length [s] of an interval."""
        return float(np.min(np.diff(self.t), initial=np.inf))

    @property
    def has_temperature(self) -> bool:
        """Whether a thermometer was read all the time."""
        return bool(np.isfinite(self.temperature).all())

    def since(self, mark: float) -> "IntervalMeans":
        """Return the means over intervals that begin after ``mark`` [s]."""
        at = self.t - self.interval >= mark - 1e-6
        accel, accel_std = (None if a is None else a[at] for a in (self.accel, self.accel_std))
        return IntervalMeans(self.t[at], self.gyro[at], self.gyro_std[at], self.temperature[at], accel, accel_std)


@dataclass(frozen=True, slots=True, eq=False)
class WarmUpState:
    """Whether positions may begin, and why not; ``left_s`` None: it cannot be reported yet.

    ``temperature_rate`` and its limit [K/s], None without a thermometer. ``gyro_drift`` (3,) is what the gyros are
    held to drift over a pair of positions, ``gyro_limit`` (3,) what a dwell resolves [count/s]; nan at first.
    """

    is_ready: bool
    left_s: float | None
    temperature_rate: float | None
    temperature_limit: float | None
    gyro_drift: FloatArray
    gyro_limit: FloatArray


def warm_up(means: IntervalMeans, dwell_s: float, pair_s: float, marks: Sequence[float] = ()) -> WarmUpState:
    """Judge whether the unit has settled, from all means since it was switched on.

    ``pair_s``: from the begin of a face's first dwell to the end of its second. ``marks`` [s]: when the cube was
    moved; only what came after the last is compared, but for the temperature, which does not mind.
    """
    rest = means.since(max(marks, default=-np.inf))
    n = len(rest.t)
    if n < MIN_MEANS:
        missing = (MIN_MEANS - n) * means.interval
        unknown = np.full(3, np.nan)
        return WarmUpState(False, missing if np.isfinite(missing) else None, None, None, unknown, unknown)
    noise = np.median(rest.gyro_std, axis=0)
    limit = noise * np.sqrt(rest.interval / dwell_s)
    enough = (48 * dwell_s * pair_s**2) ** (1 / 3)
    last = rest.since(rest.t[-1] - enough)
    slope, slope_std = trend(last.t, last.gyro, noise)
    drift, missing = np.abs(slope) * pair_s, enough - n * rest.interval
    is_steady = bool(missing <= 0 and np.all(drift < limit))
    if means.has_temperature:
        is_hot = bool(np.any(drift > limit + CLEAR_DRIFT_SIGMAS * slope_std * pair_s))
        return _by_temperature(means, rest, limit, pair_s, is_hot=is_hot, is_steady=is_steady)
    worst = int(np.argmax(drift / limit))
    tau = time_constant(rest.t, rest.gyro[:, worst], float(noise[worst]))
    left = _left(tau, float(drift[worst] / limit[worst])) if missing <= 0 else missing
    return WarmUpState(is_steady, 0.0 if is_steady else left, None, None, drift, limit)


def _by_temperature(
    means: IntervalMeans, rest: IntervalMeans, limit: FloatArray, pair_s: float, *, is_hot: bool, is_steady: bool
) -> WarmUpState:
    """Judge by the thermometer; ``is_hot``, ``is_steady``: the means show a drift, or for long enough none."""
    c, c_std = sensitivity(
        rest.temperature, rest.gyro, np.median(rest.gyro_std, axis=0), GYRO_SENSITIVITY_STD_PER_K
    )
    most = np.abs(c) + SENSITIVITY_BOUND_SIGMAS * c_std
    allowed = float(np.min(limit / most) / pair_s)
    rate, rate_std = temperature_rate(means.t, means.temperature)
    fast = abs(rate) + rate_std
    is_mute = len(means.t) < MIN_MEANS_CONSTANT_TEMPERATURE and bool(
        np.ptp(means.temperature) == 0
    )  # it may not have stepped yet
    is_slow = fast < allowed and not is_hot and not is_mute
    is_likely = bool(np.all(np.abs(c * rate) * pair_s < limit))
    left = _left(time_constant(means.t, means.temperature, scatter(means.temperature)), fast / allowed)
    is_ready = is_slow or (is_steady and is_likely)
    return WarmUpState(is_ready, 0.0 if is_ready else left, rate, allowed, most * fast * pair_s, limit)


@dataclass(frozen=True, slots=True, eq=False)
class UnsettledBias:
    """1 sigma (3,) of the biases from dwell to dwell [count/s]; ``accel`` None where it was not recorded."""

    gyro: FloatArray
    accel: FloatArray | None


def unsettled_bias(means: IntervalMeans, remaining_s: float, marks: Sequence[float] = ()) -> UnsettledBias:
    """Return what the drift seen last implies for the biases if the campaign begins now and lasts ``remaining_s``.

    A drift d leaves ``d tau exp(-t / tau)`` to go, or, where tau is not known, ``d (remaining_s - t)``. Returned
    is the root mean square of that over the campaign, at most a whole warm-up of `WARM_UP_K`.

    Raises
    ------
    ValueError
        With fewer than `MIN_MEANS` means since the last mark.
    """
    rest = means.since(max(marks, default=-np.inf))
    if len(rest.t) < MIN_MEANS:
        raise ValueError(
            f"noise and drift need {MIN_MEANS} means at rest, found {len(rest.t)}: skip it after the first minute"
        )
    tau = time_constant(means.t, means.temperature, scatter(means.temperature)) if means.has_temperature else None
    spread = _spread(remaining_s, tau)
    gyro = _drift(means, rest, rest.gyro, rest.gyro_std, GYRO_SENSITIVITY_STD_PER_K, spread)
    if rest.accel is None or rest.accel_std is None:
        return UnsettledBias(gyro, None)
    return UnsettledBias(
        gyro, _drift(means, rest, rest.accel, rest.accel_std, ACCEL_SENSITIVITY_STD_PER_K, spread)
    )


def _drift(
    means: IntervalMeans, rest: IntervalMeans, rate: FloatArray, std: FloatArray, per_kelvin: float, spread: float
) -> FloatArray:
    """Return the rms drift (3,) [count/s^2] times ``spread`` [s], within a whole warm-up."""
    noise = np.median(std, axis=0)
    if means.has_temperature:
        c, c_std = sensitivity(rest.temperature, rate, noise, per_kelvin)
        drift = np.hypot(c, c_std) * np.hypot(*temperature_rate(means.t, means.temperature))
    else:
        drift = np.hypot(*trend(rest.t, rate, noise))
    whole = per_kelvin * WARM_UP_K * np.linalg.norm(rate.mean(axis=0))
    within: FloatArray = np.minimum(drift * spread, whole)
    return within


def trend(t: FloatArray, value: FloatArray, noise: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the slope (3,) [/s] of a straight line and its 1 sigma (3,).

    Parameters
    ----------
    t : (n,) s
    value, noise : (n, 3) and 1 sigma of each column (3,), any unit
    """
    x = t - t.mean()
    slope: FloatArray = x @ value / (x @ x)
    return slope, noise / np.sqrt(x @ x)


def sensitivity(
    temperature: FloatArray, rate: FloatArray, noise: FloatArray, per_kelvin: float
) -> tuple[FloatArray, FloatArray]:
    """Return what a kelvin adds to rates (3,) [count/s/K], and its 1 sigma (3,).

    Regression with a normal prior about zero.

    Parameters
    ----------
    temperature : (n,) degC
    rate, noise : (n, 3) count/s, IMU axes, and 1 sigma of each channel (3,)
    per_kelvin : 1 sigma of the prior, of the triad's whole rate
    """
    x = temperature - temperature.mean()
    prior = per_kelvin * float(np.linalg.norm(rate.mean(axis=0)))
    weight = x @ x / noise**2 + 1 / prior**2
    c: FloatArray = x @ rate / noise**2 / weight
    return c, weight**-0.5


def temperature_rate(t: FloatArray, temperature: FloatArray) -> tuple[float, float]:
    """Return the rate [K/s] of ``temperature`` (n,) [degC] over its last means, at ``t`` (n,) [s], and 1 sigma.

    A thermometer that stands still and steps shows nothing between its steps: it is looked at for longer, and one
    step in that time is what it may hide.
    """
    steps = np.abs(np.diff(temperature))
    is_coarse = bool(np.median(steps) == 0 < steps.max())
    last = slice(-(COARSE_MEANS if is_coarse else RATE_MEANS), None)
    slope, std = trend(t[last], temperature[last, None], np.array([scatter(temperature[last])]))
    hidden = steps[steps > 0].min() / (t[last][-1] - t[last][0]) if is_coarse else 0.0
    return float(slope[0]), float(np.hypot(std[0], hidden))


def scatter(value: FloatArray) -> float:
    """Return the white noise of a smooth course ``value`` (n,), in its unit, from its second differences."""
    return float(np.sqrt(np.mean(np.diff(value, n=2) ** 2) / 6))


def time_constant(t: FloatArray, value: FloatArray, noise: float) -> float | None:
    """Return tau [s] of ``a + b exp(-t / tau)`` through ``value`` (n,); None where a straight line does as well.

    The best of `TAU_SHARES_TRIED`; it must be none of the longest and beat the line by three sigma.
    """
    t = t - t[0]

    def squares(column: FloatArray) -> float:
        A = np.stack((np.ones_like(t), column), axis=1)
        left = value - A @ np.linalg.lstsq(A, value, rcond=None)[0]
        return float(left @ left)

    taus = TAU_SHARES_TRIED * t[-1]
    found = [squares(np.exp(-t / tau)) for tau in taus]
    best = int(np.argmin(found))
    if best == len(taus) - 1 or squares(t) - found[best] <= (CLEAR_DRIFT_SIGMAS * noise) ** 2:
        return None
    return float(taus[best])


def _left(tau: float | None, ratio: float) -> float | None:
    """Return when a drift that is ``ratio`` times its limit will have decayed to it."""
    return None if tau is None else tau * float(np.log(max(ratio, 1.0)))


def _spread(seconds: float, tau: float | None) -> float:
    """Return the root mean square over ``seconds`` of what a drift of 1 /s has still to go [s]."""
    if tau is None:
        return float(seconds / np.sqrt(3.0))
    return tau * float(np.sqrt(tau / (2 * seconds) * -np.expm1(-2 * seconds / tau)))
