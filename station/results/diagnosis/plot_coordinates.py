"""The coordinate that gives an effect away: what its residual is drawn against, a line an effect."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.effects.excitation import TAU, Excitation
from procedures.effects.temperature_history import sensor_temperature
from procedures.evidence.residual_rows import Evidence
from procedures.frames import AXES
from procedures.inference.result import Finding
from procedures.units import S_PER_H

Values = Callable[[Excitation, Finding], FloatArray]  # (n,) of all sensors, or (n, 3) of each, at the nodes


@dataclass(frozen=True, slots=True, eq=False)
class Coordinate:
    """Values (n,) with a label; ``names`` where they only number steps."""

    label: str
    values: FloatArray
    names: tuple[str, ...] = ()


def coordinate_of(
    evidence: Evidence, finding: Finding, rows: BoolArray, added: FloatArray, unit: str
) -> Coordinate:
    """Return the coordinate of the rows (n,): the effect's own, the step, or what the effect adds to each.

    That is ``added`` (n,), in ``unit``. A row of all three sensors (a rest's norm) has no sensor's own coordinate.
    """
    label, values = _COORDINATES.get(finding.effect, ("step", None))
    if values is None:
        return _steps(evidence, rows)
    at_nodes = values(evidence.excitation, finding)
    axis = evidence.axis[rows]
    if at_nodes.ndim == 2 and np.any(axis < 0):
        return Coordinate(f"what {finding.effect} adds [{unit}]", added[rows])
    per_row = means_at_rows(evidence, at_nodes)[rows]
    found = per_row if per_row.ndim == 1 else per_row[np.arange(len(axis)), axis]
    if not np.isfinite(found).any():
        return _steps(evidence, rows)
    return Coordinate(label.format(**{"channel": "channel", **finding.where}), found)


def _steps(evidence: Evidence, rows: BoolArray) -> Coordinate:
    numbers, index = np.unique(evidence.step[rows], return_inverse=True)
    steps = [evidence.excitation.steps[i] for i in numbers]
    names = tuple(str(s.position) if s.kind == "dwell" else s.name.partition(".")[0] for s in steps)
    return Coordinate("position, turn or rest", index.astype(float), names)


def means_at_rows(evidence: Evidence, values: FloatArray) -> FloatArray:
    """Return the mean, in their unit, of values at the nodes (n, ...) that every row is seen at."""
    means = np.full((len(evidence.residual), *values.shape[1:]), np.nan)
    for each in evidence.weights:
        of_row = values[each.nodes]
        known = np.isfinite(of_row)
        count = np.sum(known, axis=0)
        total = np.sum(np.where(known, of_row, 0.0), axis=0)
        means[each.rows] = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    return means


def _of_inputs(vector: Callable[[Excitation], FloatArray]) -> Values:
    """Return the input (n, 3) that each sensor's largest coefficient multiplies; key xy: sensor x, input y."""

    def values(excitation: Excitation, finding: Finding) -> FloatArray:
        strength = np.zeros((3, 3))
        for name, value, std in zip(finding.coefficients, finding.value, finding.std, strict=True):
            if len(name) == 2 and std > 0:
                strength[AXES.index(name[0]), AXES.index(name[1])] = abs(value) / std
        inputs: IntArray = np.argmax(strength, axis=1)
        return vector(excitation)[:, inputs]

    return values


def _channel(excitation: Excitation, finding: Finding) -> FloatArray:
    name = str(finding.where.get("channel", ""))
    return excitation.auxiliary.get(name, np.full(len(excitation.t), np.nan))


_TEMPERATURE = ("temperature [degC]", lambda excitation, finding: excitation.temperature)


def _followed(excitation: Excitation, finding: Finding) -> FloatArray:
    tau = finding.value[finding.coefficients.index(TAU)] if TAU in finding.coefficients else 0.0
    return sensor_temperature(excitation, float(tau))


_SENSOR = ("lagged sensor temperature [degC]", _followed)
_WARMING = ("temperature rate [K/min]", lambda excitation, finding: excitation.temperature_rate)
_TIME = ("time [h]", lambda excitation, finding: (excitation.t - np.nanmin(excitation.t)) / S_PER_H)
_FORCE = ("specific force along the sensor [g]", lambda excitation, finding: excitation.f)
_RATE = ("rate about the sensor [deg/s]", lambda excitation, finding: excitation.omega)
_COORDINATES: Mapping[str, tuple[str, Values]] = {
    "accelerometer.quadratic": _FORCE,
    "accelerometer.cubic": _FORCE,
    "accelerometer.scale_asymmetry": _FORCE,
    "accelerometer.scale_temperature": _TEMPERATURE,
    "accelerometer.bias_temperature": _TEMPERATURE,
    "accelerometer.temperature_rate": _WARMING,
    "accelerometer.bias_drift": _TIME,
    "accelerometer.bias_settling": _TIME,
    "accelerometer.scale_settling": _TIME,
    "accelerometer.temperature_lag": _SENSOR,
    "accelerometer.scale_temperature_lag": _SENSOR,
    "accelerometer.temperature_hysteresis": _TEMPERATURE,
    "accelerometer.relaxation": (
        "change of specific force at the flip [g]",
        lambda excitation, finding: excitation.change,
    ),
    "gyroscope.g_sensitivity": (
        "specific force, along the input with the largest effect [g]",
        _of_inputs(lambda s: s.f),
    ),
    "gyroscope.magnetic": (
        "magnetic field, along the input with the largest effect [uT]",
        _of_inputs(lambda s: s.magnetic),
    ),
    "gyroscope.scale_temperature": _TEMPERATURE,
    "gyroscope.bias_temperature": _TEMPERATURE,
    "gyroscope.temperature_rate": _WARMING,
    "gyroscope.bias_drift": _TIME,
    "gyroscope.bias_settling": _TIME,
    "gyroscope.scale_settling": _TIME,
    "gyroscope.temperature_lag": _SENSOR,
    "gyroscope.scale_temperature_lag": _SENSOR,
    "gyroscope.temperature_hysteresis": _TEMPERATURE,
    "gyroscope.scale_asymmetry": _RATE,
    "gyroscope.scale_nonlinearity": _RATE,
    "gyroscope.sagnac_sine": _RATE,
    "gyroscope.counts_lost": _RATE,
    "auxiliary.channel": ("{channel}", _channel),
    "clock.rate": _TIME,
}
