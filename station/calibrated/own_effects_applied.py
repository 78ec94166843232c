"""What an effect adds to a triad's output at samples, by its columns: of one's own effects, and for comparison."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import REFERENCE_C, UNITS_OF_NONLINEAR, Columns, Effect, Excitation, ExcitationStep
from procedures.effects.temperature_polynomial import orders_of
from procedures.frames import AXES
from station.calibrated.effect_entries import CATALOGUE, own_effect
from station.calibrated.surroundings import Surroundings, Triad


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
