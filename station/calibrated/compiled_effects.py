"""Effects of the catalogue as the numbers that `settling_kernels` takes: polynomials, powers, matrices.

Each stands here a second time, beside its columns in `procedures.effects`: the two are held together by
`tests/station/calibrated/test_compiled_effects.py`. Effects of one's own have no such form.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.cross_product import KEYS as CROSS
from procedures.effects.effect import MATRIX, PLAY, TAU
from procedures.effects.temperature_polynomial import MAX_ORDER
from procedures.frames import AXES
from procedures.units import DEG_H_PER_DEG_S, PPM_PER_ONE
from station.calibrated.temperature_signals import DIRECTION, RATE, WARMTH, Play, Signal

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
    return (Play(values[PLAY]) if PLAY in values else known.signal or values[TAU],)


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
