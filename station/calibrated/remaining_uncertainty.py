"""The uncertainty that remains after correction, minute by minute, and the size of terms not corrected.

    u = E^-1 (N / k - D - e):   var u = (E^-1)^2 (o^2 var k / k^2 + var E u^2 + var D + (de/dc)^2 var c)

squares element by element, o = E u + D: parameters taken as independent, as calibration/1 holds no covariance of
them. Once a second; a minute's sigma is the root of its mean square. Time constants are taken as known.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isnan, nan
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.excitation import REFERENCE_C
from procedures.units import DEG_H_PER_DEG_S, RAD_PER_DEG, STANDARD_GRAVITY, UG_PER_G
from station.calibrated.applied_calibration import UNITS, CalibratedInputs, CalibrationModel
from station.calibrated.applied_effects import SampleInputs
from station.calibrated.correction_inputs import DIRECTION, RATE, WARMTH, Backlash, Signals, Surroundings

SPAN_S = 60.0
PICKED_S = 1.0  # between the samples of which the sigma is taken
SI = {"accelerometer": STANDARD_GRAVITY, "gyroscope": RAD_PER_DEG}


class SpanSigmas:
    """Gathers spans from blocks; ``C`` (3, 3) takes IMU axes to those that are wanted, axis to axis."""

    def __init__(self, model: CalibrationModel, document: Mapping[str, Any], C: FloatArray) -> None:
        self._model, self._C2 = model, C**2
        self._parts = {name: _Parts.of(document[name], UNITS[name][1]) for name in model.triads}
        self._first = self._picked = nan
        self._sum, self._count = {name: np.zeros(3) for name in SI}, dict.fromkeys(SI, 0)
        self._is_open = False
        self._number, self._begin, self._end = -1.0, nan, nan
        self._ended = list[tuple[float, float, FloatArray, FloatArray]]()

    def take(self, found: CalibratedInputs, around: Surroundings) -> None:
        """Take in a block of samples."""
        t = around.t
        if t is None or not len(t):
            return
        if isnan(self._first):
            self._first = float(t[0])
        second = np.floor((t - self._first) / PICKED_S)
        before = np.concatenate(([self._picked], second[:-1]))
        picked = np.flatnonzero(second != before)
        self._picked = float(second[-1])
        number = np.floor((t - self._first) / SPAN_S)
        cuts = np.flatnonzero(np.diff(number, prepend=self._number))
        begins = np.unique(np.concatenate(([0], cuts)))
        variances = self._variances(found, around, picked)
        for begin, end in zip(begins.tolist(), [*begins[1:].tolist(), len(t)], strict=True):
            if number[begin] != self._number:
                self._end_span()
                self._number, self._begin = float(number[begin]), float(t[begin])
            here = (picked >= begin) & (picked < end)
            for name, variance in variances.items():
                known = variance[here][np.isfinite(variance[here]).all(axis=1)]
                self._sum[name] += known.sum(axis=0)
                self._count[name] += len(known)
            self._is_open |= bool(here.any())
            self._end = float(t[end - 1])

    def ended(self, *, is_last: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the spans (m, 2) [s] that have ended since, with ``is_last`` the one that goes on as well.

        With them the standard uncertainty (m, 3) of force [m/s2] and rate [rad/s]; nan for an absent triad.
        """
        if is_last:
            self._end_span()
        found, self._ended = self._ended, []
        force, rate = (np.array([each[i] for each in found]).reshape(-1, 3) for i in (2, 3))
        return np.array([each[:2] for each in found], np.float64).reshape(-1, 2), force, rate

    def _end_span(self) -> None:
        if self._is_open:
            force, rate = (
                SI[name] * np.sqrt(self._C2 @ (self._sum[name] / self._count[name]))
                if self._count[name] else np.full(3, nan)
                for name in SI
            )  # fmt: skip
            self._ended.append((self._begin, self._end, force, rate))
        self._sum, self._count = {name: np.zeros(3) for name in SI}, dict.fromkeys(SI, 0)
        self._is_open = False

    def _variances(
        self, found: CalibratedInputs, around: Surroundings, at: "np.ndarray[Any, Any]"
    ) -> dict[str, FloatArray]:
        """Return the variance (m, 3) of each triad at picked samples [g^2], [deg^2/s^2], in IMU axes."""
        given = {"accelerometer": found.f, "gyroscope": found.omega}
        u = {name: value[at] for name, value in given.items() if value is not None}
        if not len(at) or not u:
            return {}
        variances = {name: self._parts[name].variance(u[name], self._model.triads[name]) for name in u}
        seen = SampleInputs.of(self._model.triads, u, _picked(around, at), len(at))
        left = {sentence.partition(": ")[0] for sentence in found.not_applied}
        for one in self._model.effects:
            if one.triad in variances and one.name not in left:
                variances[one.triad] += np.nan_to_num(seen.varied(one))
        return {name: value @ (self._model.triads[name].inverse ** 2).T for name, value in variances.items()}


@dataclass(frozen=True, slots=True, eq=False)
class _Parts:
    """Standard deviations of k, relative (3,), E (3, 3) and D (3,) [g], [deg/s]; what is not known is zero."""

    k: FloatArray
    E: FloatArray
    D: FloatArray

    @classmethod
    def of(cls, part: Mapping[str, Any], per: float) -> "_Parts":
        def std(name: str) -> FloatArray:
            value = np.array(part[name]["value"], dtype=np.float64)
            given = part[name].get("std")
            return np.zeros(value.shape) if given is None else np.nan_to_num(np.array(given, dtype=np.float64))

        k = np.array(part["scale_factor"]["value"], dtype=np.float64)
        return cls(std("scale_factor") / abs(k), std("misalignment"), std("bias") * per)

    def variance(self, u: FloatArray, triad: Any) -> FloatArray:
        """Return the variance (n, 3) of the output in which u (n, 3) is seen, in units of u squared."""
        output = u @ triad.E.T + triad.D
        total: FloatArray = (output * self.k) ** 2 + u**2 @ (self.E**2).T + self.D**2
        return total


def _picked(around: Surroundings, at: "np.ndarray[Any, Any]") -> Surroundings:
    assert around.t is not None
    return Surroundings(
        magnetic=None if around.magnetic is None else around.magnetic[at],
        auxiliary={name: value[at] for name, value in around.auxiliary.items()}, t=around.t[at],
        signals={signal: value[at] for signal, value in around.followed.items()},
    )  # fmt: skip


ANY_RANGE_K = 20.0  # about 25 degC, where a calibration does not say what it saw
WARMING_K_MIN = 1.0  # of a unit that warms up
EARTH_FIELD_UT = 50.0
RATE_DEG_S = 100.0  # at which terms that depend on a rate are reported
SHOWN_UNITS = {"accelerometer": ("ug", UG_PER_G), "gyroscope": ("deg/h", DEG_H_PER_DEG_S)}


def size_of(model: CalibrationModel, document: Mapping[str, Any], name: str) -> str:
    """Return how large an effect may be, in words; empty where that is not known.

    At 1 g and 100 deg/s along every axis, at the ends of the calibration's temperatures, at 1 K/min and 50 uT.
    """
    effect = next((each for each in model.effects if each.name == name), None)
    if effect is None or effect.triad not in model.triads:
        return ""
    low, high = document.get("temperature_range_c") or (REFERENCE_C - ANY_RANGE_K, REFERENCE_C + ANY_RANGE_K)
    warmth = np.array([low, high, low, high], dtype=np.float64) - REFERENCE_C
    sign = np.array([1.0, 1.0, -1.0, -1.0])
    signals: Signals = {
        WARMTH: warmth, RATE: sign * WARMING_K_MIN, DIRECTION: sign,
        **{one: sign if isinstance(one, Backlash) else warmth for one in model.signals},
    }  # fmt: skip
    field = np.full((4, 3), EARTH_FIELD_UT) * sign[:, None]
    input_of = {"accelerometer": np.ones((4, 3)), "gyroscope": np.full((4, 3), RATE_DEG_S)}
    u: dict[str, FloatArray] = {each: input_of[each] * sign[:, None] for each in model.triads}
    added = SampleInputs.of(model.triads, u, Surroundings(magnetic=field, signals=signals), 4).added(effect)
    unit, per = SHOWN_UNITS[effect.triad]
    if np.isfinite(added).all() and (most := float(np.abs(added).max()) * per):
        return f"up to {float(f'{most:.2g}'):g} {unit}"
    return ""


def lacking(
    model: CalibrationModel, document: Mapping[str, Any], channels: Sequence[str], triads: Sequence[str], *,
    has_temperature: bool,
) -> dict[str, str]:  # fmt: skip
    """Return by name how large the effects are whose inputs a recording with these channels and triads lacks."""
    one = np.ones((1, 3))
    around = Surroundings(
        temperature=np.array([REFERENCE_C]) if has_temperature else None, t=np.zeros(1),
        auxiliary={name: np.zeros(1) for name in channels},
    )  # fmt: skip
    accel, gyro = (one * 0 if name in triads else None for name in ("accelerometer", "gyroscope"))
    found = model.inputs(accel, gyro, around).not_applied
    names = [sentence.partition(": ")[0] for sentence in found]
    return {name: size_of(model, document, name) for name in names if name in model.taken_off}
