"""How large an effect is that is not corrected: the most that it may add within what the calibration saw."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.effects.effect import REFERENCE_C
from procedures.units import DEG_H_PER_DEG_S, UG_PER_G
from station.calibrated.calibration_applied import CalibrationModel
from station.calibrated.own_effects_applied import added_by, excitation
from station.calibrated.surroundings import Surroundings
from station.calibrated.temperature_signals import TemperatureSignals

ANY_RANGE_K = 20.0  # about 25 degC, where a calibration does not say what it saw
WARMING_K_MIN = 1.0  # of a unit that warms up
EARTH_FIELD_UT = 50.0
RATE_DEG_S = 100.0  # at which what goes with a rate is told
UNITS = {"accelerometer": ("ug", UG_PER_G), "gyroscope": ("deg/h", DEG_H_PER_DEG_S)}


def size_of(model: CalibrationModel, document: Mapping[str, Any], name: str) -> str:
    """Return how large an effect may be, in words; empty where that is not known.

    At 1 g and 100 deg/s along every axis, at the ends of the calibration's temperatures, at 1 K/min and 50 uT.
    """
    entry = next((each for each in model.effects if each["name"] == name), None)
    if entry is None:
        return ""
    low, high = document.get("temperature_range_c") or (REFERENCE_C - ANY_RANGE_K, REFERENCE_C + ANY_RANGE_K)
    warmth = np.array([low, high, low, high], dtype=np.float64) - REFERENCE_C
    sign = np.array([1.0, 1.0, -1.0, -1.0])
    lagged, branch = dict.fromkeys(model.taus, warmth), dict.fromkeys(model.plays, sign)
    signals = TemperatureSignals(warmth, sign * WARMING_K_MIN, sign, lagged, branch)
    field = np.full((4, 3), EARTH_FIELD_UT) * sign[:, None]
    input_of = {"accelerometer": np.ones((4, 3)), "gyroscope": np.full((4, 3), RATE_DEG_S)}
    u: dict[str, FloatArray] = {each: input_of[each] * sign[:, None] for each in model.triads}
    seen = excitation(model.triads, u, Surroundings(magnetic=field, signals=signals), 4)
    said = list[str]()
    for triad, added in added_by(entry, seen).items():
        unit, per = UNITS[triad]
        if np.isfinite(added).all() and (most := float(np.abs(added).max()) * per):
            said.append(f"up to {float(f'{most:.2g}'):g} {unit}")
    return " and ".join(said)


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
