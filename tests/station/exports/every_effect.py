"""A calibration with every effect that a program carries, of plausible sizes, and one that no program does."""

from typing import Any

import numpy as np

from procedures.effects import CATALOGUE
from procedures.effects.effect import Effect
from procedures.effects.term.law import Law
from tests.station.calibrated.test_calibration_applied import calibration, effect

AXES = "xyz"
MATRIX = [a + b for a in AXES for b in AXES]
OF_OWN_SIZE = (
    effect("accelerometer.quadratic", x=6e-5, y=-5e-5, z=1e-5),
    effect("accelerometer.cubic", x=2e-5, y=1e-5, z=-1e-5),
    effect("accelerometer.scale_asymmetry", x=100.0, y=-50.0, z=20.0),
    effect("accelerometer.cross_product", xxy=2e-5, xyz=4e-6, yyz=-1e-5, zxz=3e-5),
    effect("accelerometer.bias_temperature", **{"x.1": 1e-5, "x.2": -3e-7, "x.3": 2e-8, "z.1": -4e-5}),
    effect("accelerometer.scale_temperature", x=20.0, y=-10.0, z=5.0),
    effect("accelerometer.temperature_rate", x=2e-5, y=1e-5, z=-1e-5),
    effect("accelerometer.temperature_lag", x=5e-5, y=-3e-5, z=1e-5, tau_s=600.0),
    effect("accelerometer.scale_temperature_lag", x=50.0, y=-30.0, z=10.0, tau_s=300.0),
    effect("accelerometer.temperature_hysteresis", x=5e-5, y=-3e-5, z=1e-5),
    effect("gyroscope.g_sensitivity", **{key: 0.5 * (1 + i) for i, key in enumerate(MATRIX)}),
    effect("gyroscope.bias_temperature", **{"x.1": 0.3, "y.1": -0.1, "y.2": 0.01, "z.1": 0.2}),
    effect("gyroscope.scale_temperature", **{"x.1": 20.0, "y.1": -10.0, "y.2": 0.3, "z.1": 5.0}),
    effect("gyroscope.temperature_rate", x=3.0, y=1.0, z=-2.0),
    effect("gyroscope.temperature_lag", **{"y.1": 0.3, "y.2": -0.01, "tau_s": 600.0}),
    effect("gyroscope.scale_temperature_lag", x=50.0, y=-30.0, z=10.0, tau_s=200.0),
    effect("gyroscope.temperature_hysteresis", x=0.5, y=-0.3, z=0.1),
    effect("gyroscope.magnetic", **{key: 0.05 * (1 + i) for i, key in enumerate(MATRIX)}),
    effect("gyroscope.scale_asymmetry", x=100.0, y=-50.0, z=20.0),
    effect("gyroscope.scale_nonlinearity", "u |u|", x=1.0, y=-2.0, z=2.0),
    effect("gyroscope.scale_nonlinearity", "u^3", x=0.01, y=-0.02, z=0.02),
    effect("gyroscope.sagnac_sine", x=1e-3, y=-5e-4, z=5e-4),
)


def of_plausible_size(one: Effect, law: Law) -> dict[str, Any]:
    """Return every coefficient of an effect at its plausible size, parameters in the middle of their range."""
    ends = {key: (each.low, each.high) for key, each in law.parameters.items()}
    middle = {key: float(np.sqrt(low * high)) if np.isfinite(high) else 300.0 for key, (low, high) in ends.items()}
    found = effect(one.name, law.shape, **dict.fromkeys(law.coefficients, law.plausible), **middle)
    return {**found, "unit": law.unit}


KNOWN = {(one["name"], one.get("shape", "")) for one in OF_OWN_SIZE}
EFFECTS = (
    *OF_OWN_SIZE,
    *(
        of_plausible_size(one, law)
        for one in CATALOGUE.values()
        for law in one.laws
        if not one.not_corrected and (one.name, law.shape) not in KNOWN and "backlash" not in law.equation
    ),
)
DRIFT = {**effect("accelerometer.bias_drift", x=1e-5), "unit": "g/h"}


def every_effect(*more: dict[str, Any]) -> dict[str, Any]:
    """Return a calibration/1 of every effect, and more of them."""
    return {**with_facts(calibration(*EFFECTS, *more)), "temperature_range_c": [5.0, 45.0]}


def with_facts(document: dict[str, Any]) -> dict[str, Any]:
    """Return a calibration/1 that says whose it is and how long it holds."""
    return {
        **document, "model": "FOG-3", "serial": "S7", "software": "station 1", "status": "calibrated",
        "accepted_utc": "2026-03-04T12:00:00Z", "valid_from": "2026-03-04T12:00:00Z", "previous": "0" * 64,
        "valid_until": "2027-03-04T00:00:00Z",
    }  # fmt: skip
