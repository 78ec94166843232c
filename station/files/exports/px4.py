"""PX4: ``accel = R ((raw - thermal - offset) .* scale)``, ``gyro = R (raw - thermal - offset)``.

The offsets are CAL_ACC0_XOFF and CAL_GYRO0_XOFF ..., the scale CAL_ACC0_XSCALE ...:
PX4/PX4-Autopilot, src/lib/sensor_calibration: Accelerometer.hpp and Gyroscope.hpp, ``Correct``; m/s2 and rad/s, in
the sensor's own axes, R turns them to the board's. Gyros have no scale. PX4 and this project both take
an accelerometer's output as specific force, so no sign changes. A calibration is used only where CAL_ACC0_ID and
CAL_GYRO0_ID are the sensor's own device id (``FindCurrentCalibrationIndex``), which a calibration does not know.
Accelerometer.cpp and Gyroscope.cpp, ``set_offset``: a running PX4 ignores changes below 0.01 (m/s2, rad/s).

File: what QGroundControl loads (ParameterManager.cc, ``writeParametersToStream``): vehicle, component, name, value
and MAV_PARAM_TYPE (9 = float) between tabs, comments behind #.
"""

from station.files.exports.correction import Correction
from station.files.exports.offset_and_scale import lost, parameters

VEHICLE, COMPONENT, FLOAT = 1, 1, 9


def text(correction: Correction) -> str:
    """Return a QGroundControl ``.params`` file."""
    lines = [f"# {line}" for line in ("PX4 parameters", *correction.remarks, *lost(correction), *_WARNINGS)]
    values = parameters(correction, "CAL_ACC0_{}OFF", "CAL_ACC0_{}SCALE", "CAL_GYRO0_{}OFF")
    rows = [f"{VEHICLE}\t{COMPONENT}\t{name}\t{value:.9g}\t{FLOAT}" for name, value in values.items()]
    return "\n".join([*lines, "#", "# Vehicle-Id Component-Id Name Value Type", *rows, ""])


_WARNINGS = (
    "axes are the IMU's own; SENS_BOARD_ROT or CAL_ACC0_ROT turns them to the vehicle's",
    "CAL_ACC0_ID and CAL_GYRO0_ID must be the sensor's device id, else PX4 does not use these values",
    "restart after loading: a running PX4 ignores changes of offset and scale below 0.01",
)
