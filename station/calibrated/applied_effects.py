"""Error terms of a `calibration/1` that can be corrected, compiled for `settling_kernels` or by their own columns.

Each stands here a second time, beside its columns in `procedures.effects`: the two are held together by
`tests/station/calibrated/test_compiled_effects.py`. Effects of one's own have no such form.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects import EFFECTS
from procedures.effects.cross_product import KEYS as CROSS
from procedures.effects.effect import (
    MATRIX,
    PLAY,
    REFERENCE_C,
    TAU,
    UNITS_OF_NONLINEAR,
    Columns,
    Effect,
    Excitation,
    ExcitationStep,
)
from procedures.effects.temperature_polynomial import MAX_ORDER, orders_of
from procedures.effects.term.inputs import AUXILIARY
from procedures.frames import AXES
from procedures.units import DEG_H_PER_DEG_S, PPM_PER_ONE
from station.calibrated.correction_inputs import DIRECTION, RATE, WARMTH, Backlash, Signal, Surroundings, Triad
from station.errors import DataRefused
from station.files.effect_file import EffectFile, stored_effect

PER_DEG_H, PER_PPM = 1 / DEG_H_PER_DEG_S, 1 / PPM_PER_ONE  # of deg/s, of one


@dataclass(frozen=True, slots=True)
class Polynomial:
    """A polynomial of ``signal`` (empty: a lag) in ``part``, bias or scale; ``per`` is its unit in g, deg/s, 1."""

    signal: str
    part: str
    per: float


POLYNOMIALS: Mapping[str, Polynomial] = {
    f"{triad}.{name}": Polynomial(signal, part, PER_PPM if part == "scale" else per)
    for triad, per in (("accelerometer", 1.0), ("gyroscope", PER_DEG_H))
    for name, signal, part in (
        ("bias_temperature", WARMTH, "bias"),
        ("scale_temperature", WARMTH, "scale"),
        ("temperature_rate", RATE, "bias"),
        ("temperature_lag", "", "bias"),
        ("scale_temperature_lag", "", "scale"),
        ("temperature_hysteresis", DIRECTION, "bias"),
    )
}
# By name and shape: the row of `settling_kernels._of_input`, and the unit
POWERS: Mapping[tuple[str, str], tuple[int, float]] = {
    ("accelerometer.scale_asymmetry", ""): (0, 0.5 * PER_PPM),
    ("gyroscope.scale_asymmetry", ""): (0, 0.5 * PER_PPM),
    ("accelerometer.quadratic", ""): (1, 1.0),
    ("gyroscope.scale_nonlinearity", "u |u|"): (2, PER_PPM),
    ("accelerometer.cubic", ""): (3, 1.0),
    ("gyroscope.scale_nonlinearity", "u^3"): (3, PER_PPM),
    ("gyroscope.sagnac_sine", ""): (4, 1.0),
}
SINE = 4


@dataclass(frozen=True, slots=True, eq=False)
class CompiledEffects:
    """What a triad's effects add; ``bias`` and ``scale`` (signals, 3, orders) are polynomials of ``signals``.

    ``matrix`` (3, 3) [deg/s] is of the specific force in g, ``magnetic`` (3, 3) [deg/s] of the field in uT,
    ``powers`` (5, 3) and ``cross`` (3, 3) are of the triad's own input.
    """

    signals: tuple[Signal, ...]
    bias: FloatArray
    scale: FloatArray
    matrix: FloatArray
    magnetic: FloatArray
    powers: FloatArray
    cross: FloatArray


def is_compiled(entry: Mapping[str, Any]) -> bool:
    """Say whether an effect of a `calibration/1` is one of the catalogue that has this form."""
    name = str(entry["name"])
    known = name in POLYNOMIALS or name in _MATRICES or name == _CROSS or (name, entry.get("shape", "")) in POWERS
    return known and "definition" not in entry


def signals_of(entry: Mapping[str, Any]) -> tuple[Signal, ...]:
    """Return what an effect that `is_compiled` goes with, besides the input."""
    known = POLYNOMIALS.get(str(entry["name"]))
    if known is None:
        return ()
    values = _values(entry)
    return (Backlash(values[PLAY]) if PLAY in values else known.signal or values[TAU],)


def compiled(entries: Sequence[Mapping[str, Any]], triad: str) -> CompiledEffects:
    """Return what the effects of a triad add together; ``entries`` are those that `is_compiled`."""
    own = [entry for entry in entries if str(entry["name"]).startswith(f"{triad}.")]
    signals = tuple(dict.fromkeys(signal for entry in own for signal in signals_of(entry)))
    shape = (len(signals), len(AXES), MAX_ORDER)
    square, rows = (3, 3), (SINE + 1, 3)
    found = CompiledEffects(signals, *map(np.zeros, (shape, shape, square, square, rows, square)))
    for entry in own:
        name, values = str(entry["name"]), _values(entry)
        if name in POLYNOMIALS:
            known = POLYNOMIALS[name]
            into = found.bias if known.part == "bias" else found.scale
            _add_polynomial(into[signals.index(signals_of(entry)[0])], values, known.per)
        elif name in _MATRICES:
            for row, column, value in _of_matrix(values, MATRIX):
                getattr(found, _MATRICES[name])[row, column] += value * PER_DEG_H
        elif name == _CROSS:
            for row, column, value in _of_matrix(values, CROSS):
                found.cross[row, column] += value
        else:
            row, per = POWERS[name, entry.get("shape", "")]
            power = np.array([values.get(axis, 0.0) for axis in AXES])
            found.powers[row] += power * abs(power) if row == SINE else per * power
    return replace(found, bias=_without_zeros(found.bias), scale=_without_zeros(found.scale))


def _without_zeros(polynomials: FloatArray) -> FloatArray:
    """Return polynomials without the highest orders that none of them has."""
    used = np.flatnonzero(polynomials.any(axis=(0, 1)))
    return np.ascontiguousarray(polynomials[:, :, : used[-1] + 1 if len(used) else 0])


_MATRICES = {"gyroscope.g_sensitivity": "matrix", "gyroscope.magnetic": "magnetic"}
_CROSS = "accelerometer.cross_product"


def _values(entry: Mapping[str, Any]) -> dict[str, float]:
    return {key: float(one["value"]) for key, one in entry["coefficients"].items()}


def _add_polynomial(into: FloatArray, values: Mapping[str, float], per: float) -> None:
    for key, value in values.items():
        axis, _, order = key.partition(".")
        if axis in AXES:
            into[AXES.index(axis), int(order or 1) - 1] += per * value


def _of_matrix(values: Mapping[str, float], keys: Sequence[str]) -> list[tuple[int, int, float]]:
    return [(i // 3, i % 3, values[key]) for i, key in enumerate(keys) if key in values]


TRANSIENT_EFFECTS = (
    "accelerometer.bias_drift", "gyroscope.bias_drift", "accelerometer.relaxation",
    "accelerometer.bias_settling", "gyroscope.bias_settling", "accelerometer.scale_settling",
    "gyroscope.scale_settling",
)  # fmt: skip
LOST = ("gyroscope.counts_lost",)
CATALOGUE: Mapping[str, Effect] = {effect.name: effect for effect in EFFECTS}


def left_for_good(entry: Mapping[str, Any]) -> str:
    """Return why an effect is never corrected, empty if it may be; raises as `own_effect`."""
    name = str(entry["name"])
    if "definition" in entry:
        if own_effect(entry).term.looks_back:
            return "specific to the campaign or to earlier steps; one sample does not determine it"
        return ""
    if name in TRANSIENT_EFFECTS:
        return "specific to the campaign, not a constant of the instrument"
    if name not in CATALOGUE:
        return "not in this program's catalogue"
    if name in LOST:
        return "counts lost above a rate cannot be restored"
    if not is_compiled(entry):
        return "specific to the campaign; one sample does not determine it"
    if not all(tau > 0 for tau in temperature_lags(entry)):
        return "a time constant that is not above zero"
    return "" if all(width > 0 for width in backlashes(entry)) else "a backlash that is not above zero"


def needs(entry: Mapping[str, Any], around: Surroundings, triads: set[str]) -> str:
    """Return what an effect lacks in the surroundings, empty if it lacks nothing."""
    name = str(entry["name"])
    if name.split(".")[0] not in triads:
        return ""
    return "the quantity that it depends on was not recorded" if _lacks(entry, around, triads) else ""


def _lacks(entry: Mapping[str, Any], around: Surroundings, triads: set[str]) -> bool:
    signals = around.followed
    if "definition" in entry:
        return any(not _is_known(name, around, triads) for name in own_effect(entry).term.inputs)
    name = str(entry["name"])
    if name == "gyroscope.magnetic":
        return around.magnetic is None or not np.isfinite(around.magnetic).any()
    if name == "gyroscope.g_sensitivity":
        return "accelerometer" not in triads
    return any(not np.isfinite(signals.of(signal)).any() for signal in signals_of(entry))


def _is_known(name: str, around: Surroundings, triads: set[str]) -> bool:
    """Say whether an input of a term is known at any sample."""
    signals = around.followed
    word = name.partition("_")[0]
    if word == "aux":
        value = around.auxiliary.get(name.removeprefix(AUXILIARY))
        return value is not None and bool(np.isfinite(value).any())
    if word == "B":
        return around.magnetic is not None and bool(np.isfinite(around.magnetic).any())
    if word == "T":
        return bool(np.isfinite(signals.rate if name == "T_rate" else signals.warmth).any())
    of_triad = {"f": "accelerometer", "omega": "gyroscope"}
    return of_triad.get(word, next(iter(triads))) in triads


def temperature_lags(entry: Mapping[str, Any]) -> tuple[float, ...]:
    """Return the time constants [s] by which an effect follows the temperature."""
    values = {name: float(one["value"]) for name, one in entry.get("coefficients", {}).items()}
    if "definition" not in entry:
        return (values[TAU],) if TAU in values else ()
    term = own_effect(entry).term
    return term.temperature_lags({name: values[name] for name in term.parameters})


def backlashes(entry: Mapping[str, Any]) -> tuple[float, ...]:
    """Return the half widths [K] with which an effect of the catalogue follows the temperature with a play."""
    play = None if "definition" in entry else entry.get("coefficients", {}).get(PLAY)
    return () if play is None else (float(play["value"]),)


def own_effect(entry: Mapping[str, Any]) -> EffectFile:
    """Return the `effect/1` of an entry that has one.

    Raises
    ------
    DataRefused
        If it is not what was stored, or a parameter of its term has no value.
    """
    name = str(entry["name"])
    found = stored_effect(str(entry["definition"]), str(entry.get("sha256", "")), name)
    if entry.get("unit", found.term.unit) != found.term.unit:
        raise DataRefused(f"effects.{name}", None, f"unit {entry['unit']!r}", f"{found.term.unit!r}, its term's")
    for parameter in found.term.parameters:
        if parameter not in entry.get("coefficients", {}):
            expected = "a value of every parameter of its term"
            raise DataRefused(f"effects.{name}", None, f"no value of {parameter}", expected, "solve it again")
    return found


def added_by(entry: Mapping[str, Any], seen: Excitation) -> dict[str, FloatArray]:
    """Return what an effect adds (n, 3) to each triad's output [g], [deg/s]; nan where it cannot be known."""
    effect = own_effect(entry).effect if "definition" in entry else CATALOGUE[str(entry["name"])]
    way = _way(effect, entry, seen)
    if way is None:
        return {"accelerometer": np.full(seen.f.shape, np.nan)}
    coefficients, nothing = entry["coefficients"], {"value": 0.0}
    values = [coefficients.get(key, coefficients.get(key.removesuffix(".1"), nothing)) for key in way.coefficients]
    fitted = zip(way.coefficients, values, strict=True)
    c = np.array([0.0 if key in way.nonlinear else value["value"] for key, value in fitted])
    c = c if effect.fitted is None else effect.fitted(c)
    if effect.added is not None:
        return {effect.name.split(".")[0]: effect.added(seen, c)[0]}
    parts = {"accelerometer": way.accel, "gyroscope": way.gyro}
    return {name: part @ c for name, part in parts.items() if part is not None}


def varied_by(entry: Mapping[str, Any], seen: Excitation) -> dict[str, FloatArray]:
    """Return the variance (n, 3) of what an effect adds, by the sigmas of its coefficients [g^2], [deg^2/s^2]."""
    effect = own_effect(entry).effect if "definition" in entry else CATALOGUE[str(entry["name"])]
    way = _way(effect, entry, seen)
    if way is None:
        return {}
    coefficients = entry["coefficients"]
    known = [coefficients.get(key, coefficients.get(key.removesuffix(".1"), {})) for key in way.coefficients]
    std = np.array([0.0 if key in way.nonlinear else one.get("std") or 0.0
                    for key, one in zip(way.coefficients, known, strict=True)])  # fmt: skip
    if effect.fitted is not None:
        value = np.array([float(one.get("value", 0.0)) for one in known])
        std = effect.fitted(abs(value) + std) - effect.fitted(abs(value))
    parts = {"accelerometer": way.accel, "gyroscope": way.gyro}
    return {name: part**2 @ std**2 for name, part in parts.items() if part is not None}


def _way(effect: Effect, entry: Mapping[str, Any], seen: Excitation) -> Columns | None:
    """Return how an effect acts, as its entry says: by shape, time constant and coefficients."""
    shape = entry.get("shape", "")
    if effect.at is None:
        return next((way for way in effect.columns(seen) if way.shape == shape), None)
    keys = entry["coefficients"]
    fitted = tuple(effect.ranges) if "definition" in entry else tuple(UNITS_OF_NONLINEAR)
    nonlinear = {name: float(keys[name]["value"]) for name in fitted if name in keys}
    return effect.at(seen, Columns((), shape=shape, nonlinear=nonlinear, orders=orders_of(list(keys))))


def excitation(
    triads: Mapping[str, Triad], u: Mapping[str, FloatArray], around: Surroundings, n: int
) -> Excitation:
    """Return the samples as an effect's columns take them, at inputs ``u`` (n, 3) [g], [deg/s]; unknown is nan."""
    signals = around.followed
    one, three = np.full(n, np.nan), np.full((n, 3), np.nan)
    frames = {name: np.broadcast_to(triad.E, (n, 3, 3)) for name, triad in triads.items()}
    unit = np.broadcast_to(np.eye(len(AXES)), (n, 3, 3))
    output = {name: u[name] @ triads[name].E.T + triads[name].D for name in u}
    return Excitation(
        f=u.get("accelerometer", three), omega=u.get("gyroscope", three),
        magnetic=three if around.magnetic is None else around.magnetic,
        accel_output=output.get("accelerometer", three), gyro_output=output.get("gyroscope", three),
        change=three, t=one if around.t is None else around.t, rest_s=one,
        temperature=signals.warmth + REFERENCE_C, temperature_rate=signals.rate, auxiliary=around.auxiliary,
        step=np.zeros(n, dtype=np.int64), C_sb=unit,
        E_accel=frames.get("accelerometer", unit), E_gyro=frames.get("gyroscope", unit),
        steps=(ExcitationStep("", "sample", 0, 0, ""),),
        sensor_temperature={tau: lagged + REFERENCE_C for tau, lagged in signals.lagged.items()},
        direction=signals.direction, branch=signals.branch,
    )  # fmt: skip
