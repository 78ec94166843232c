"""ArduPilot: ``accel = (raw - INS_ACCOFFS) * INS_ACCSCAL`` in m/s/s, ``gyro = raw - INS_GYROFFS`` in rad/s.

In that order, in the sensor's own axes, before the board is rotated: ArduPilot/ardupilot,
libraries/AP_InertialSensor/AP_InertialSensor_Backend.cpp, ``_rotate_and_correct_accel`` and
``_rotate_and_correct_gyro`` (offsets are subtracted, then each axis is multiplied by its scale; gyros have none).
Units and ranges: AP_InertialSensor.cpp, ``@Param: _ACCOFFS_X`` (m/s/s, -3.5 to 3.5), ``_ACCSCAL_X`` (0.8 to 1.2),
``_GYROFFS_X`` (rad/s, set up anew at each boot unless INS_GYR_CAL is 0). ArduPilot and this project both take an
accelerometer's output as specific force, so no sign changes.
"""

from station.files.exports.correction import Correction
from station.files.exports.offset_and_scale import lost, parameters

SCALE_RANGE = (0.8, 1.2)
MAX_OFFSET_M_S2 = 3.5  # m/s/s


def text(correction: Correction) -> str:
    """Return a parameter file: NAME,VALUE, comments behind #."""
    values = parameters(correction, "INS_ACCOFFS_{}", "INS_ACCSCAL_{}", "INS_GYROFFS_{}")
    if correction.gyroscope is not None:
        values["INS_GYR_CAL"] = 0
    lines = [f"# {line}" for line in ("ArduPilot parameters", *correction.remarks, *lost(correction))]
    lines += [f"# {line}" for line in _warnings(correction, values)]
    return "\n".join([*lines, *(f"{name},{value:.9g}" for name, value in values.items()), ""])


def _warnings(correction: Correction, values: dict[str, float]) -> list[str]:
    said = ["axes are the IMU's own; AHRS_ORIENTATION turns them to the vehicle's"]
    if correction.gyroscope is not None:
        said.append("INS_GYR_CAL 0 keeps INS_GYROFFS: else they are measured anew at each start")
    for name, value in values.items():
        if "SCAL" in name and not SCALE_RANGE[0] <= value <= SCALE_RANGE[1]:
            low, high = SCALE_RANGE
            said.append(f"{name} is outside {low} to {high}: give --nominal-accel as the driver has it")
        if "ACCOFFS" in name and abs(value) > MAX_OFFSET_M_S2:
            said.append(f"{name} is outside +-{MAX_OFFSET_M_S2} m/s/s: the vehicle will not arm")
    return said
