"""The laws of the catalogue once more, in plain numpy: what a unit of each coefficient adds, in g or deg/s."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from procedures.arrays import FloatArray


@dataclass(frozen=True)
class Felt:
    """What a triad felt at n moments: vectors (n, 3) in g, deg/s, uT, g^2; all else (n,), K above 25 degC, s.

    ``behind`` is a temperature that follows with a lag, ``branch`` where a hysteresis with a play is, ``tau``,
    ``period`` [s], ``knee`` [deg/s] what an effect has in addition to its coefficients.
    """

    u: FloatArray
    out: FloatArray
    f: FloatArray
    B: FloatArray
    T: FloatArray
    rate: FloatArray
    behind: FloatArray
    direction: FloatArray
    branch: FloatArray
    t: FloatArray | None = None
    since_power_on: FloatArray | None = None
    at_rest: FloatArray | None = None  # time since a rest began, nan outside of rests
    change: FloatArray | None = None
    vibration: FloatArray | None = None
    tau: float = 1.0
    knee: float = 0.0
    period: float = 1.0


Value = Callable[[Felt], FloatArray]  # (n, 3, terms)
ORDER = 3
DEG_H, PPM = 1 / 3600, 1e-6


def of(value: Callable[[Felt], FloatArray], per: float = 1.0) -> Value:
    """One term: a value (n, 3), or (n,) that is the same for all sensors."""

    def whole(felt: Felt) -> FloatArray:
        found = value(felt)
        return per * np.broadcast_to(found.reshape(len(found), -1), felt.u.shape)[:, :, None]

    return whole


def powers(value: Callable[[Felt], FloatArray], per: float, *, of_output: bool = False) -> Value:
    """Powers of a temperature, times the output of a scale factor."""

    def whole(felt: Felt) -> FloatArray:
        each = np.stack([value(felt) ** n for n in range(1, ORDER + 1)], axis=1)[:, None, :]
        return per * each * (felt.out[:, :, None] if of_output else np.ones((1, 3, 1)))

    return whole


def vector(value: Callable[[Felt], FloatArray], per: float) -> Value:
    """Three terms that all sensors share."""
    return lambda felt: per * np.repeat(value(felt)[:, None, :], 3, axis=1)


def fading(felt: Felt) -> FloatArray:
    assert felt.at_rest is not None
    return np.nan_to_num(np.exp(-felt.at_rest / felt.tau))[:, None]


def settling(felt: Felt) -> FloatArray:
    assert felt.since_power_on is not None
    return np.exp(-felt.since_power_on / felt.tau)


def cycle(per: float) -> Value:
    """Sine and cosine of one period for all sensors."""

    def whole(felt: Felt) -> FloatArray:
        assert felt.since_power_on is not None
        turning = np.exp(2j * np.pi * felt.since_power_on / felt.period)
        return per * np.repeat(np.stack((turning.imag, turning.real), axis=1)[:, None, :], 3, axis=1)

    return whole


def settling_output(felt: Felt) -> FloatArray:
    moves = felt.out.max(axis=0) - felt.out.min(axis=0) > abs(felt.out).max(axis=0) / 2
    return settling(felt)[:, None] * felt.out * moves


def pairs(felt: Felt) -> FloatArray:
    return np.stack([felt.f[:, i] * felt.f[:, j] for i, j in combinations(range(3), 2)], axis=1)


def asymmetry(felt: Felt) -> FloatArray:
    return abs(felt.u) / 2


def lost(felt: Felt) -> FloatArray:
    out = felt.out
    return -np.where(abs(out) > felt.knee, abs(out) - felt.knee, 0.0) * np.sign(out)


BY_HAND: Mapping[tuple[str, str], Value] = {
    ("accelerometer.quadratic", ""): of(lambda felt: felt.u**2),
    ("accelerometer.cubic", ""): of(lambda felt: felt.u**3),
    ("accelerometer.scale_asymmetry", ""): of(asymmetry, PPM),
    ("gyroscope.scale_asymmetry", ""): of(asymmetry, PPM),
    ("accelerometer.cross_product", ""): vector(pairs, 1.0),
    ("gyroscope.g_sensitivity", ""): vector(lambda felt: felt.f, DEG_H),
    ("gyroscope.magnetic", ""): vector(lambda felt: felt.B, DEG_H),
    ("gyroscope.scale_nonlinearity", "u |u|"): of(lambda felt: felt.u * abs(felt.u), PPM),
    ("gyroscope.scale_nonlinearity", "u^3"): of(lambda felt: felt.u**3, PPM),
    ("gyroscope.sagnac_sine", ""): of(lambda felt: -(felt.u**3) / 6),  # of q = s^2, to first order
    ("gyroscope.counts_lost", ""): of(lost, PPM),
    ("gyroscope.temperature_rate_lag", ""): of(lambda felt: 60 * (felt.T - felt.behind) / felt.tau, DEG_H),
    ("accelerometer.relaxation", ""): of(fading),
    ("accelerometer.relaxation", "by the change of f"): of(lambda felt: fading(felt) * np.nan_to_num(felt.change)),
    ("accelerometer.relaxation", "by f"): of(lambda felt: fading(felt) * felt.f),
    ("accelerometer.vibration_rectification", ""): of(lambda felt: np.asarray(felt.vibration)),
    ("gyroscope.vibration_rectification", ""): of(lambda felt: np.asarray(felt.vibration).sum(axis=1), DEG_H),
    **{
        (f"{triad}.{name}", shape): value
        for triad, per in (("accelerometer", 1.0), ("gyroscope", DEG_H))
        for name, shape, value in (
            ("bias_temperature", "", powers(lambda felt: felt.T, per)),
            ("scale_temperature", "", powers(lambda felt: felt.T, PPM, of_output=True)),
            ("temperature_rate", "", of(lambda felt: felt.rate, per)),
            ("temperature_lag", "", powers(lambda felt: felt.behind, per)),
            ("scale_temperature_lag", "", powers(lambda felt: felt.behind, PPM, of_output=True)),
            ("temperature_hysteresis", "", of(lambda felt: felt.direction, per)),
            ("temperature_hysteresis", "with a play", of(lambda felt: felt.branch, per)),
            ("bias_drift", "", of(lambda felt: np.asarray(felt.t) / 3600, per)),
            ("bias_settling", "", of(settling, per)),
            ("bias_cycle", "", cycle(per)),
            ("scale_settling", "", of(settling_output, PPM)),
        )
    },
}
