"""A `calibration/1` applied to counts: specific force and angular rate, its error terms corrected.

    N / k = E u + D + e(u, T, ...)        u <- E^-1 (N / k - D - e(u, T, ...))

Terms of the usual forms are corrected a sample after the other (`settling_kernels`), others around that, until u
stands still: a round gains as many digits as they change slower than u.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.frames import TRIADS
from procedures.units import DEG_H_PER_DEG_S
from station.calibrated.applied_effects import (
    AppliedEffect,
    CompiledEffects,
    SampleInputs,
    applied_effect,
    compiled,
)
from station.calibrated.correction_inputs import (
    NOTHING_KNOWN,
    RATE,
    WARMTH,
    Signal,
    Surroundings,
    TemperatureFollower,
    Triad,
)
from station.calibrated.settling_kernels import settle

MAX_ITERATIONS = 100
CONVERGED: Mapping[str, Any] = {"rtol": 1e-13, "atol": 1e-13, "equal_nan": True}  # a round has not moved a sample
UNITS = {"accelerometer": ("g", 1.0), "gyroscope": ("deg/s", 1 / DEG_H_PER_DEG_S)}  # of u; of a bias as it stands


@dataclass(frozen=True, slots=True, eq=False)
class CalibratedInputs:
    """Specific force ``f`` (n, 3) [g] and angular rate ``omega`` (n, 3) [deg/s], IMU axes; absent triads are None.

    ``unsettled`` (n,) are samples whose effects do not settle: nan in f or omega. ``not_applied`` names effects
    that were not corrected, and why.
    """

    f: FloatArray | None
    omega: FloatArray | None
    unsettled: BoolArray
    not_applied: tuple[str, ...] = ()


def calibrated_inputs(
    calibration: Mapping[str, Any],
    accel: FloatArray | None,
    gyro: FloatArray | None,
    around: Surroundings = NOTHING_KNOWN,
) -> CalibratedInputs:
    """Return what the sensors felt, from ``accel`` and ``gyro`` (n, 3) [count/s], or rates as they came.

    An effect of gyroscopes that depends on specific force needs both triads.
    """
    return CalibrationModel.of(calibration).inputs(accel, gyro, around)


@dataclass(frozen=True, eq=False)
class CalibrationModel:
    """A `calibration/1` as it is applied: its triads by name, and the ``effects`` that are corrected.

    ``names`` are those of all that it holds; ``left`` says why some are not corrected, whatever is known.
    """

    triads: Mapping[str, Triad]
    effects: tuple[AppliedEffect, ...]
    left: Mapping[str, str]
    names: tuple[str, ...]

    @classmethod
    def of(cls, calibration: Mapping[str, Any]) -> "CalibrationModel":
        """Return the model of a `calibration/1`; an effect of one's own that is not whole is `DataRefused`."""
        triads = {name: Triad.of(calibration[name], UNITS[name][1]) for name in TRIADS if name in calibration}
        found = [(str(entry["name"]), applied_effect(entry)) for entry in calibration["effects"]]
        left = {name: one for name, one in found if isinstance(one, str)}
        effects = (one for name, one in found if not isinstance(one, str) and name not in left)
        return cls(triads, tuple(effects), left, tuple(dict.fromkeys(name for name, _ in found)))

    @cached_property
    def signals(self) -> tuple[Signal, ...]:
        """The lags and backlashes by which its effects follow the temperature."""
        return tuple(signal for one in self.effects for signal in one.signals)

    def follower(self) -> TemperatureFollower:
        """Return what follows the temperature as its effects do."""
        return TemperatureFollower(self.signals)

    @property
    def taken_off(self) -> tuple[str, ...]:
        """The names of its ``effects``."""
        return tuple(one.name for one in self.effects)

    def without(self, names: tuple[str, ...]) -> "CalibrationModel":
        """Return it without some of its effects."""
        return replace(
            self,
            effects=tuple(one for one in self.effects if one.name not in names),
            left={name: reason for name, reason in self.left.items() if name not in names},
            names=tuple(name for name in self.names if name not in names),
        )

    def inputs(
        self, accel: FloatArray | None, gyro: FloatArray | None, around: Surroundings = NOTHING_KNOWN
    ) -> CalibratedInputs:
        """Return what the sensors felt, of ``accel`` and ``gyro`` (n, 3) [count/s], as `calibrated_inputs`."""
        rates = {"accelerometer": accel, "gyroscope": gyro}
        output = {
            name: np.asarray(rate, np.float64) / self.triads[name].k
            for name in TRIADS
            if (rate := rates[name]) is not None and name in self.triads
        }
        n = len(next(iter(output.values()), np.zeros((0, 3))))
        around = _with_signals(around, self.follower(), n)
        not_known = {one.name: one.needs(around, set(output)) for one in self.effects}
        reasons = {name: self.left.get(name) or not_known.get(name, "") for name in self.names}
        left = {name: reason for name, reason in reasons.items() if reason}
        effects = [one for one in self.effects if one.name not in left]
        unsettled = np.zeros(n, dtype=np.bool_)
        u = self._settled(output, effects, around, unsettled) if n else output
        texts = tuple(f"{name}: {reason}" for name, reason in left.items())
        return CalibratedInputs(u.get("accelerometer"), u.get("gyroscope"), unsettled, texts)

    def _settled(
        self, output: Mapping[str, FloatArray], effects: list[AppliedEffect], around: Surroundings,
        unsettled: BoolArray,
    ) -> dict[str, FloatArray]:  # fmt: skip
        known = tuple(one for one in effects if one.is_compiled)
        kernels = {name: compiled(known, name) for name in output}
        others = [one for one in effects if not one.is_compiled and one.triad in output]
        u = self._by_kernels(output, kernels, dict.fromkeys(output, np.zeros((0, 3))), around, unsettled)
        if not others:
            return u
        with np.errstate(all="ignore"):  # what grows beyond all bounds is nan at the end
            for _ in range(MAX_ITERATIONS):
                off = self._added(others, u, around)
                before, u = u, self._by_kernels(output, kernels, off, around, unsettled)
                stands = {name: np.isclose(u[name], before[name], **CONVERGED).all(axis=1) for name in u}
                if all(each.all() for each in stands.values()):
                    break
        is_known = np.isfinite(np.hstack(list(output.values()))).all(axis=1)
        for name, value in u.items():
            lost = ~(stands[name] & np.isfinite(value).all(axis=1))
            u[name] = np.where(lost[:, None], np.nan, value)
            unsettled |= lost & is_known
        return u

    def _added(
        self, others: list[AppliedEffect], u: Mapping[str, FloatArray], around: Surroundings
    ) -> dict[str, FloatArray]:
        """Return what effects without a kernel add (n, 3) to each triad's output at inputs u."""
        n = len(next(iter(u.values())))
        seen = SampleInputs.of(self.triads, u, around, n)
        off = {name: np.zeros((n, 3)) for name in u}
        for one in others:
            off[one.triad] += np.nan_to_num(seen.added(one))
        return off

    def _by_kernels(
        self, output: Mapping[str, FloatArray], kernels: Mapping[str, CompiledEffects],
        extra: Mapping[str, FloatArray], around: Surroundings, unsettled: BoolArray,
    ) -> dict[str, FloatArray]:  # fmt: skip
        u, none = dict[str, FloatArray](), np.zeros((0, 3))
        for name in ("accelerometer", "gyroscope"):  # in this order: g-sensitivity takes the specific force
            if name not in output:
                continue
            triad, off, kernel = self.triads[name], extra[name], kernels[name]
            if kernel.magnetic.any():
                field = np.nan_to_num(np.asarray(around.magnetic)) @ kernel.magnetic.T
                off = field + off if len(off) else field
            force = u["accelerometer"] if kernel.matrix.any() else none
            found = np.empty_like(output[name])
            settle(
                output[name], triad.E, triad.inverse, triad.D, kernel.bias, kernel.scale,
                _rows(kernel.signals, around, len(found)), np.ascontiguousarray(off), kernel.matrix, force,
                kernel.powers, kernel.cross, np.empty((4, 3)), found, unsettled,
            )  # fmt: skip
            u[name] = found
        return u


def _with_signals(around: Surroundings, follower: TemperatureFollower, n: int) -> Surroundings:
    """Return the surroundings with signals; what is not known of them is nan."""
    signals = around.signals
    if signals is None:
        t = np.zeros(n) if around.t is None else around.t
        signals = follower.take(t, around.temperature)
        if around.t is None:
            unknown = np.full(n, np.nan)
            signals = {**dict.fromkeys(signals, unknown), WARMTH: signals[WARMTH]}
    if around.temperature_rate is not None:
        signals = {**signals, RATE: around.temperature_rate}
    return replace(around, signals=signals)


def _rows(names: tuple[Signal, ...], around: Surroundings, n: int) -> FloatArray:
    rows: FloatArray = np.stack([around.followed[name] for name in names]) if names else np.zeros((0, n))
    return np.ascontiguousarray(rows)


def compile_all() -> None:
    """Apply a calibration without errors to twenty samples."""
    triad = {"scale_factor": {"value": [1.0] * 3}, "misalignment": {"value": np.eye(3).tolist()},
             "bias": {"value": [0.0] * 3}}  # fmt: skip
    model = CalibrationModel.of({"accelerometer": triad, "gyroscope": triad, "effects": []})
    nothing = np.zeros((20, 3))
    model.inputs(nothing, nothing, Surroundings(temperature=np.full(20, 25.0), t=np.arange(20.0)))


if __name__ == "__main__":
    compile_all()
