"""PX4: ``accel = R ((raw - thermal - offset) .* scale)``, ``gyro = R (raw - thermal - offset)``.

The offsets are CAL_ACC0_XOFF and CAL_GYRO0_XOFF ..., the scale CAL_ACC0_XSCALE ...:
PX4/PX4-Autopilot, src/lib/sensor_calibration: Accelerometer.hpp and Gyroscope.hpp, ``Correct``; m/s2 and rad/s, in
the sensor's own axes, R turns them to the board's. Gyros have no scale. PX4 and this project both take
an accelerometer's output as specific force, so no sign changes. A calibration is used only where CAL_ACC0_ID and
CAL_GYRO0_ID are the sensor's own device id (``FindCurrentCalibrationIndex``), which a calibration does not know.
Accelerometer.cpp and Gyroscope.cpp, ``set_offset``: a running PX4 ignores changes below 0.01 (m/s2, rad/s).

``thermal = X0 + X1 (T - TREF) + X2 (T - TREF)^2 + X3 (T - TREF)^3``, T held between TMIN and TMAX, TC_A0_X1_0 ...
of axis 0, 1, 2 in m/s2 or rad/s per degC^n: src/modules/temperature_compensation/TemperatureCompensation.cpp,
``calc_thermal_offsets_3D``; used where TC_A_ENABLE is 1 and TC_A0_ID the sensor's. Ends: `parameter_lists`.

File: what QGroundControl loads (ParameterManager.cc, ``writeParametersToStream``): vehicle, component, name, value
and MAV_PARAM_TYPE (9 = float) between tabs, comments behind #.
"""

from procedures.effects.effect import REFERENCE_C
from station.exports.correction import Correction
from station.exports.offset_and_scale import effects_lost, lost, parameters
from station.exports.parameter_lists import PX4, outside

VEHICLE, COMPONENT, FLOAT, INT32 = 1, 1, 9, 6


def text(correction: Correction) -> str:
    """Return a QGroundControl ``.params`` file."""
    values = parameters(correction, "CAL_ACC0_{}OFF", "CAL_ACC0_{}SCALE", "CAL_GYRO0_{}OFF") | _thermal(correction)
    said = ["PX4 parameters", *correction.remarks, *lost(correction)]
    said += [*effects_lost(correction, takes_temperature=True), *_WARNINGS]
    said += [f"{name} is outside {one.low:g} to {one.high:g}" for name, one in outside(values, PX4)]
    if correction.thermal:
        said.append("TC_A0_ID and TC_G0_ID must be the sensor's device id as well")
    lines = [f"# {line}" for line in said]
    rows = [
        f"{VEHICLE}\t{COMPONENT}\t{name}\t{value:.9g}\t{INT32 if PX4[name].is_whole else FLOAT}"
        for name, value in values.items()
    ]
    return "\n".join([*lines, "#", "# Vehicle-Id Component-Id Name Value Type", *rows, ""])


def _thermal(correction: Correction) -> dict[str, float]:
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
