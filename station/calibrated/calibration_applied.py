"""A `calibration/1` applied to counts: from rates to specific force and angular rate, its effects taken off.

    N / k = E u + D + e(u, T, ...)        u <- E^-1 (N / k - D - e(u, T, ...))

repeated until u stands still: a round gains as many digits as e changes slower than u, four of most effects, half
a one of a sine that is bent by 0.8 rad.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects import EFFECTS
from procedures.effects.effect import TAU, Columns, Effect, Excitation, ExcitationStep
from procedures.effects.temperature_polynomial import orders_of
from procedures.frames import AXES
from procedures.units import DEG_H_PER_DEG_S
from station.errors import DataRefused
from station.files.effect_file import EffectFile, stored_effect

MAX_ITERATIONS = 100
CONVERGENCE_RTOL = 1e-13  # relative
TRANSIENT_EFFECTS = ("accelerometer.bias_drift", "gyroscope.bias_drift", "accelerometer.relaxation")


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What the sensors were in at n samples, each (n,) or (n, 3), None where unknown.

    ``temperature`` [degC], ``temperature_rate`` [K/min], ``magnetic`` [uT] in IMU axes, ``auxiliary`` by channel;
    ``t`` [s] rises. Of what was before: ``followed`` holds by time constant [s] a time [s] and the temperature
    [degC] that a sensor had come to, ``direction`` is 1 where it grew warmer, -1 where it cooled. Without them the
    sensors are as warm as the first sample says.
    """

    temperature: FloatArray | None = None
    temperature_rate: FloatArray | None = None
    magnetic: FloatArray | None = None
    auxiliary: Mapping[str, FloatArray] = field(default_factory=dict)
    t: FloatArray | None = None
    followed: Mapping[float, tuple[float, float]] = field(default_factory=dict)
    direction: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class CalibratedInputs:
    """Specific force ``f`` (n, 3) [g] and angular rate ``omega`` (n, 3) [deg/s], IMU axes; absent triads are None.

    ``not_applied`` names effects that were left in, and why.
    """

    f: FloatArray | None
    omega: FloatArray | None
    not_applied: tuple[str, ...] = ()


def calibrated_inputs(
    calibration: Mapping[str, Any],
    accel: FloatArray | None,
    gyro: FloatArray | None,
    around: Surroundings = Surroundings(),
) -> CalibratedInputs:
    """Return what the sensors felt, from ``accel`` and ``gyro`` (n, 3) [count/s], or rates as they came.

    An effect of gyroscopes that depends on specific force needs both triads.
    """
    triads = {
        name: _Triad.of(calibration[name], per)
        for name, rate, per in (("accelerometer", accel, 1.0), ("gyroscope", gyro, 1 / DEG_H_PER_DEG_S))
        if rate is not None and name in calibration
    }
    rates = {"accelerometer": accel, "gyroscope": gyro}
    output: dict[str, FloatArray] = {name: np.array(rates[name], float) / t.k for name, t in triads.items()}
    u = {name: triad.invert(output[name]) for name, triad in triads.items()}
    n = len(next(iter(output.values()), np.zeros((0, 3))))
    effects, left = _applicable(calibration["effects"], triads, around, n)
    for _ in range(MAX_ITERATIONS if effects else 0):
        seen = _seen(triads, u, around, n)
        off = {name: np.zeros((n, 3)) for name in triads}
        for effect, entry in effects:
            for name, added in _added(effect, entry, seen).items():
                if name in off:
                    off[name] += added
        before, u = u, {name: triad.invert(output[name] - off[name]) for name, triad in triads.items()}
        if all(np.allclose(u[name], before[name], rtol=CONVERGENCE_RTOL, atol=CONVERGENCE_RTOL) for name in u):
            break
    return CalibratedInputs(u.get("accelerometer"), u.get("gyroscope"), left)


@dataclass(frozen=True, slots=True, eq=False)
class _Triad:
    """k (3,), E (3, 3), D (3,) in g or deg/s."""

    k: FloatArray
    E: FloatArray
    D: FloatArray

    @classmethod
    def of(cls, part: Mapping[str, Any], per: float) -> "_Triad":
        names = ("scale_factor", "misalignment", "bias")
        k, E, D = (np.array(part[name]["value"], dtype=np.float64) for name in names)
        return cls(k, E, D * per)

    def invert(self, output: FloatArray) -> FloatArray:
        u: FloatArray = (output - self.D) @ np.linalg.inv(self.E).T
        return u


def _applicable(
    entries: list[Mapping[str, Any]], triads: Mapping[str, _Triad], around: Surroundings, n: int
) -> tuple[list[tuple[Effect, Mapping[str, Any]]], tuple[str, ...]]:
    """Return the effects that can be taken off, and what is said of the others."""
    catalogue = {effect.name: effect for effect in EFFECTS}
    found, left = list[tuple[Effect, Mapping[str, Any]]](), list[str]()
    seen = _seen(triads, {name: np.ones((n, 3)) for name in triads}, around, n)
    for entry in entries:
        name, own = str(entry["name"]), own_effect(entry) if "definition" in entry else None
        effect = catalogue.get(name) if own is None else own.effect  # the catalogue may have had its name since
        if own is not None and own.term.looks_back:
            left.append(f"{name}: of the campaign, or of what was before; one sample does not tell it")
        elif own is None and name in TRANSIENT_EFFECTS:
            left.append(f"{name}: of the campaign, not of the instrument for good")
        elif effect is None:
            left.append(f"{name}: not in this program's catalogue")
        elif any(not np.isfinite(added).all() for added in _added(effect, entry, seen).values()):
            left.append(f"{name}: what it depends on was not recorded")
        else:
            found.append((effect, entry))
    return found, tuple(left)


def _added(effect: Effect, entry: Mapping[str, Any], seen: Excitation) -> dict[str, FloatArray]:
    """Return what an effect adds (n, 3) to each triad's output [g], [deg/s]; nan where it cannot be known."""
    coefficients = entry["coefficients"]
    way = _way(effect, entry, seen)
    if way is None:
        return {"accelerometer": np.full(seen.f.shape, np.nan)}
    nothing = {"value": 0.0}
    values = [coefficients.get(key, coefficients.get(key.removesuffix(".1"), nothing)) for key in way.coefficients]
    fitted = zip(way.coefficients, values, strict=True)
    c = np.array([0.0 if key in way.nonlinear else value["value"] for key, value in fitted])
    c = c if effect.fitted is None else effect.fitted(c)
    if effect.added is not None:
        return {effect.name.split(".")[0]: effect.added(seen, c)[0]}
    parts = {"accelerometer": way.accel, "gyroscope": way.gyro}
    return {name: part @ c for name, part in parts.items() if part is not None}


def _way(effect: Effect, entry: Mapping[str, Any], seen: Excitation) -> Columns | None:
    """Return how an effect acts, as its entry says: by shape, time constant and coefficients."""
    shape = entry.get("shape", "")
    if effect.at is None:
        return next((way for way in effect.columns(seen) if way.shape == shape), None)
    keys = entry["coefficients"]
    fitted = tuple(effect.ranges) if "definition" in entry else (TAU,)
    nonlinear = {name: float(keys.get(name, {"value": 0.0})["value"]) for name in fitted}
    return effect.at(seen, Columns((), shape=shape, nonlinear=nonlinear, orders=orders_of(list(keys))))


def own_effect(entry: Mapping[str, Any]) -> EffectFile:
    """Return the `effect/1` of an entry that has one.

    Raises
    ------
    DataRefused
        If it is not what was stored, or a parameter of its term has no value.
    """
    name = str(entry["name"])
    found = stored_effect(str(entry["definition"]), str(entry.get("sha256", "")), name)
    for parameter in found.term.parameters:
        if parameter not in entry.get("coefficients", {}):
            expected = "one of every parameter of its term"
            raise DataRefused(f"effects.{name}", None, f"no value of {parameter}", expected, "solve it again")
    return found


def _seen(triads: Mapping[str, _Triad], u: Mapping[str, FloatArray], around: Surroundings, n: int) -> Excitation:
    """Return the samples as an effect's columns take them; what is not known is nan."""
    one, three = np.full(n, np.nan), np.full((n, 3), np.nan)
    frames = {name: np.broadcast_to(triad.E, (n, 3, 3)) for name, triad in triads.items()}
    unit = np.broadcast_to(np.eye(len(AXES)), (n, 3, 3))
    output = {name: u[name] @ triad.E.T + triad.D for name, triad in triads.items()}
    temperature = one if around.temperature is None else around.temperature
    rate = one if around.temperature_rate is None else around.temperature_rate
    return Excitation(
        f=u.get("accelerometer", three), omega=u.get("gyroscope", three),
        magnetic=three if around.magnetic is None else around.magnetic,
        accel_output=output.get("accelerometer", three), gyro_output=output.get("gyroscope", three),
        change=three, t=one if around.t is None else around.t, rest_s=one,
        temperature=temperature, temperature_rate=rate, auxiliary=around.auxiliary,
        step=np.zeros(n, dtype=np.int64), C_sb=unit,
        E_accel=frames.get("accelerometer", unit), E_gyro=frames.get("gyroscope", unit),
        steps=(ExcitationStep("", "sample", 0, 0, ""),), followed=around.followed, direction=around.direction,
    )  # fmt: skip
