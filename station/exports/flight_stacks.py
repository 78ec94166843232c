"""Parameters of the flight stacks ArduPilot and PX4, with the limits of their parameter lists.

ArduPilot: ``accel = (raw - P - INS_ACCOFFS) * INS_ACCSCAL``, ``gyro = raw - P - INS_GYROFFS``, m/s/s and rad/s, in
that order, in the sensor's own axes, before the board is rotated: ArduPilot/ardupilot,
libraries/AP_InertialSensor/AP_InertialSensor_Backend.cpp, ``_rotate_and_correct_accel`` and
``_rotate_and_correct_gyro`` (temperature, offsets, then each axis is multiplied by its scale; gyros have none).
``P = p(T) - p(CALTEMP)``, both temperatures held between TMIN and TMAX; p is a cubic without a constant of
``T - 35 degC``, whose coefficients INS_TCAL1_ACC1_X ... are in 1e-6 of m/s/s or rad/s per degC^n:
AP_InertialSensor_tempcal.cpp, ``correct_sensor``, ``polynomial_eval``.
An arming check refuses INS_ACCOFFS beyond its ends. ArduPilot and this project both take an accelerometer's output
as specific force, so no sign changes.

PX4: ``accel = R ((raw - thermal - offset) .* scale)``, ``gyro = R (raw - thermal - offset)``.
The offsets are CAL_ACC0_XOFF and CAL_GYRO0_XOFF ..., the scale CAL_ACC0_XSCALE ...:
PX4/PX4-Autopilot, src/lib/sensor_calibration: Accelerometer.hpp and Gyroscope.hpp, ``Correct``; m/s2 and rad/s, in
the sensor's own axes, R turns them to the board's. Gyros have no scale. PX4 and this project both take
an accelerometer's output as specific force, so no sign changes. A calibration is used only where CAL_ACC0_ID and
CAL_GYRO0_ID are the sensor's own device id (``FindCurrentCalibrationIndex``), which a calibration does not know.
Accelerometer.cpp and Gyroscope.cpp, ``set_offset``: a running PX4 ignores changes below 0.01 (m/s2, rad/s).

``thermal = X0 + X1 (T - TREF) + X2 (T - TREF)^2 + X3 (T - TREF)^3``, T held between TMIN and TMAX, TC_A0_X1_0 ...
of axis 0, 1, 2 in m/s2 or rad/s per degC^n: src/modules/temperature_compensation/TemperatureCompensation.cpp,
``calc_thermal_offsets_3D``; used where TC_A_ENABLE is 1 and TC_A0_ID the sensor's.

File: what QGroundControl loads (ParameterManager.cc, ``writeParametersToStream``): vehicle, component, name, value
and MAV_PARAM_TYPE (9 = float) between tabs, comments behind #.

Limits of the parameters as the stacks' own lists have them. PX4/PX4-Autopilot, main,
src/modules/temperature_compensation/temp_comp_params_accel_0.yaml (354b7a4d29) and
its like for gyros, src/modules/sensors/module.yaml (04be11a6b9): no ends but the scale's. A name has at most 16
characters, a value is a 32-bit float or integer.

ArduPilot: ArduPilot/ardupilot, master (4.7.0-dev), libraries/AP_InertialSensor: AP_InertialSensor_tempcal.cpp
(025810d325), AP_InertialSensor.cpp, ``@Param`` and ``@Range``.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from procedures.effects.excitation import REFERENCE_C
from station.exports.correction import Correction, effects_lost, lost, parameters

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
    found = [(name, value, listed[name]) for name, value in values.items()]
    return [(name, one) for name, value, one in found if not one.low <= value <= one.high]


def clipped(name: str, value: float, listed: Mapping[str, Listed]) -> float:
    """Return a value, in its own unit, as near as its parameter's ends let it be."""
    return min(max(value, listed[name].low), listed[name].high)


TEMP_REFERENCE = 35.0  # degC
SCALE_FACTOR = 1e6
NAMES = {"accelerometer": "ACC", "gyroscope": "GYR"}


def ardupilot_text(correction: Correction) -> str:
    """Return a parameter file: NAME,VALUE, comments behind #."""
    thermal, at_c = _ardupilot_thermal(correction)
    values = parameters(correction, "INS_ACCOFFS_{}", "INS_ACCSCAL_{}", "INS_GYROFFS_{}", at_c)
    if correction.gyroscope is not None:
        values["INS_GYR_CAL"] = 0
    values |= thermal
    texts = ["ArduPilot parameters", *correction.remarks, *lost(correction)]
    texts += [*effects_lost(correction, takes_temperature=True), *_warnings(correction, values)]
    rows = [f"{name},{value:.9g}" for name, value in values.items()]
    return "\n".join([*(f"# {line}" for line in texts), *rows, ""])


def _ardupilot_thermal(correction: Correction) -> tuple[dict[str, float], float]:
    """Return the parameters of the temperature, and at which [degC] the offsets are to hold."""
    if not correction.thermal:
        return {}, REFERENCE_C
    ends = [(one.low, one.high) for one in correction.thermal.values()]
    low = clipped("INS_TCAL1_TMIN", max(one[0] for one in ends), ARDUPILOT)
    high = clipped("INS_TCAL1_TMAX", min(one[1] for one in ends), ARDUPILOT)
    at_c = min(max(REFERENCE_C, low), high)
    values: dict[str, float] = {"INS_TCAL1_ENABLE": 1, "INS_TCAL1_TMIN": low, "INS_TCAL1_TMAX": high}
    for name, one in correction.thermal.items():
        cubic = one.about(TEMP_REFERENCE) * SCALE_FACTOR
        values[f"INS_{NAMES[name]}1_CALTEMP"] = at_c
        for n in range(1, 4):
            values |= {f"INS_TCAL1_{NAMES[name]}{n}_{axis}": float(cubic[i, n]) for i, axis in enumerate("XYZ")}
    return values, at_c


def _warnings(correction: Correction, values: dict[str, float]) -> list[str]:
    texts = ["axes are the IMU's own; AHRS_ORIENTATION turns them to the vehicle's"]
    if correction.gyroscope is not None:
        texts.append("INS_GYR_CAL 0 keeps INS_GYROFFS: else they are measured again at each start")
    for name, one in outside(values, ARDUPILOT):
        remedy = "give --nominal-accel as the driver has it" if "SCAL" in name else "the vehicle will not arm"
        texts.append(f"{name} is outside {one.low:g} to {one.high:g} {one.unit}".rstrip() + f": {remedy}")
    low, high = ARDUPILOT["INS_TCAL1_TMIN"].low, ARDUPILOT["INS_TCAL1_TMAX"].high
    for name, thermal in correction.thermal.items():
        if thermal.low < low or thermal.high > high:
            texts.append(f"{name} offset by temperature: cut to {low:g} to {high:g} degC, which INS_TCAL1 takes")
    return texts


VEHICLE, COMPONENT, FLOAT, INT32 = 1, 1, 9, 6


def px4_text(correction: Correction) -> str:
    """Return a QGroundControl ``.params`` file."""
    values = parameters(correction, "CAL_ACC0_{}OFF", "CAL_ACC0_{}SCALE", "CAL_GYRO0_{}OFF") | _px4_thermal(
        correction
    )
    texts = ["PX4 parameters", *correction.remarks, *lost(correction)]
    texts += [*effects_lost(correction, takes_temperature=True), *_WARNINGS]
    texts += [f"{name} is outside {one.low:g} to {one.high:g}" for name, one in outside(values, PX4)]
    if correction.thermal:
        texts.append("TC_A0_ID and TC_G0_ID must be the sensor's device id as well")
    lines = [f"# {line}" for line in texts]
    rows = [
        f"{VEHICLE}\t{COMPONENT}\t{name}\t{value:.9g}\t{INT32 if PX4[name].is_whole else FLOAT}"
        for name, value in values.items()
    ]
    return "\n".join([*lines, "#", "# Vehicle-Id Component-Id Name Value Type", *rows, ""])


def _px4_thermal(correction: Correction) -> dict[str, float]:
    values = dict[str, float]()
    for name, one in correction.thermal.items():
        letter = "A" if name == "accelerometer" else "G"
        values |= {
            f"TC_{letter}_ENABLE": 1, f"TC_{letter}0_TREF": REFERENCE_C,
            f"TC_{letter}0_TMIN": one.low, f"TC_{letter}0_TMAX": one.high,
        }  # fmt: skip
        values |= {f"TC_{letter}0_X{n}_{axis}": float(one.cubic[axis, n]) for n in range(4) for axis in range(3)}
    return values


_WARNINGS = (
    "axes are the IMU's own; SENS_BOARD_ROT or CAL_ACC0_ROT turns them to the vehicle's",
    "CAL_ACC0_ID and CAL_GYRO0_ID must be the sensor's device id, else PX4 does not use these values",
    "restart after loading: a running PX4 ignores changes of offset and scale below 0.01",
)
