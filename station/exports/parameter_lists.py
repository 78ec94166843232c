"""Parameters of flight stacks as their own lists have them: which there are, and between which ends.

PX4: PX4/PX4-Autopilot, main, src/modules/temperature_compensation/temp_comp_params_accel_0.yaml (354b7a4d29) and
its like for gyros, src/modules/sensors/module.yaml (04be11a6b9): no ends but the scale's. A name has at most 16
characters, a value is a 32-bit float or integer.

ArduPilot: ArduPilot/ardupilot, master (4.7.0-dev), libraries/AP_InertialSensor: AP_InertialSensor_tempcal.cpp
(025810d325), AP_InertialSensor.cpp, ``@Param`` and ``@Range``.
"""

from collections.abc import Mapping
from dataclasses import dataclass

AXES = "XYZ"
MAX_NAME = 16  # characters: MAVLink's PARAM_VALUE
MAX_FLOAT = 3.4e38


@dataclass(frozen=True, slots=True)
class Listed:
    """A parameter: its ends, in its ``unit``, and whether it is a whole number."""

    unit: str = ""
    low: float = -MAX_FLOAT
    high: float = MAX_FLOAT
    is_whole: bool = False


PX4: Mapping[str, Listed] = {
    **{f"CAL_ACC0_{axis}OFF": Listed("m/s^2") for axis in AXES},
    **{f"CAL_ACC0_{axis}SCALE": Listed("", 0.1, 3.0) for axis in AXES},
    **{f"CAL_GYRO0_{axis}OFF": Listed("rad/s") for axis in AXES},
    **{f"TC_{triad}_ENABLE": Listed("", 0, 1, is_whole=True) for triad in "AG"},
    **{f"TC_{triad}0_{end}": Listed("degC") for triad in "AG" for end in ("TMIN", "TMAX", "TREF")},
    **{
        f"TC_{triad}0_X{n}_{axis}": Listed(f"{unit}/degC^{n}")
        for triad, unit in (("A", "m/s^2"), ("G", "rad/s"))
        for n in range(4)
        for axis in range(3)
    },
}
ARDUPILOT: Mapping[str, Listed] = {
    **{f"INS_ACCOFFS_{axis}": Listed("m/s/s", -3.5, 3.5) for axis in AXES},
    **{f"INS_ACCSCAL_{axis}": Listed("", 0.8, 1.2) for axis in AXES},
    **{f"INS_GYROFFS_{axis}": Listed("rad/s") for axis in AXES},
    "INS_GYR_CAL": Listed("", 0, 1, is_whole=True),
    "INS_ACC1_CALTEMP": Listed("degC"),
    "INS_GYR1_CALTEMP": Listed("degC"),
    "INS_TCAL1_ENABLE": Listed("", 0, 2, is_whole=True),
    "INS_TCAL1_TMIN": Listed("degC", -70, 80),
    "INS_TCAL1_TMAX": Listed("degC", -70, 80),
    **{
        f"INS_TCAL1_{triad}{n}_{axis}": Listed(f"1e-6 {unit}/degC^{n}")
        for triad, unit in (("ACC", "m/s/s"), ("GYR", "rad/s"))
        for n in range(1, 4)
        for axis in AXES
    },
}


def outside(values: Mapping[str, float], listed: Mapping[str, Listed]) -> list[tuple[str, Listed]]:
    """Return the parameters whose value, in its own unit, is beyond an end; each is on the list."""
    return [(name, listed[name]) for name, value in values.items() if not _is_inside(value, listed[name])]


def clipped(name: str, value: float, listed: Mapping[str, Listed]) -> float:
    """Return a value, in its own unit, as near as its parameter's ends let it be."""
    return min(max(value, listed[name].low), listed[name].high)


def _is_inside(value: float, one: Listed) -> bool:
    return one.low <= value <= one.high
