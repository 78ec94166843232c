"""ArduPilot: ``accel = (raw - P - INS_ACCOFFS) * INS_ACCSCAL``, ``gyro = raw - P - INS_GYROFFS``, m/s/s and rad/s.

In that order, in the sensor's own axes, before the board is rotated: ArduPilot/ardupilot,
libraries/AP_InertialSensor/AP_InertialSensor_Backend.cpp, ``_rotate_and_correct_accel`` and
``_rotate_and_correct_gyro`` (temperature, offsets, then each axis is multiplied by its scale; gyros have none).
``P = p(T) - p(CALTEMP)``, both temperatures held between TMIN and TMAX; p is a cubic without a constant of
``T - 35 degC``, whose coefficients INS_TCAL1_ACC1_X ... are in 1e-6 of m/s/s or rad/s per degC^n:
AP_InertialSensor_tempcal.cpp, ``correct_sensor``, ``polynomial_eval``. Ends of the parameters: `parameter_lists`.
An arming check refuses INS_ACCOFFS beyond its ends. ArduPilot and this project both take an accelerometer's output
as specific force, so no sign changes.
"""

from procedures.effects.effect import REFERENCE_C
from station.exports.correction import Correction
from station.exports.offset_and_scale import effects_lost, lost, parameters
from station.exports.parameter_lists import ARDUPILOT, clipped, outside

TEMP_REFERENCE = 35.0  # degC
SCALE_FACTOR = 1e6
NAMES = {"accelerometer": "ACC", "gyroscope": "GYR"}


def text(correction: Correction) -> str:
    """Return a parameter file: NAME,VALUE, comments behind #."""
    thermal, at_c = _thermal(correction)
    values = parameters(correction, "INS_ACCOFFS_{}", "INS_ACCSCAL_{}", "INS_GYROFFS_{}", at_c)
    if correction.gyroscope is not None:
        values["INS_GYR_CAL"] = 0
    values |= thermal
    said = ["ArduPilot parameters", *correction.remarks, *lost(correction)]
    said += [*effects_lost(correction, takes_temperature=True), *_warnings(correction, values)]
    rows = [f"{name},{value:.9g}" for name, value in values.items()]
    return "\n".join([*(f"# {line}" for line in said), *rows, ""])


def _thermal(correction: Correction) -> tuple[dict[str, float], float]:
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
    said = ["axes are the IMU's own; AHRS_ORIENTATION turns them to the vehicle's"]
    if correction.gyroscope is not None:
        said.append("INS_GYR_CAL 0 keeps INS_GYROFFS: else they are measured again at each start")
    for name, one in outside(values, ARDUPILOT):
        remedy = "give --nominal-accel as the driver has it" if "SCAL" in name else "the vehicle will not arm"
        said.append(f"{name} is outside {one.low:g} to {one.high:g} {one.unit}".rstrip() + f": {remedy}")
    low, high = ARDUPILOT["INS_TCAL1_TMIN"].low, ARDUPILOT["INS_TCAL1_TMAX"].high
    for name, thermal in correction.thermal.items():
        if thermal.low < low or thermal.high > high:
            said.append(f"{name} offset by temperature: cut to {low:g} to {high:g} degC, which INS_TCAL1 takes")
    return said
