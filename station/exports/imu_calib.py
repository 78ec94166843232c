"""imu_calib of ROS: ``corrected = SM raw - bias`` in m/s2, of the accelerometers alone.

dpkoch/imu_calib, src/accel_calib/accel_calib.cpp, ``applyCalib`` and ``loadCalib``: keys SM, nine numbers row by
row, and bias, three. Its node apply_calib takes the mean of the gyroscopes while it starts as their bias, unless
``calibrate_gyros`` is false, and corrects nothing else of them.
"""

import numpy as np

from station.errors import DataRefused
from station.exports.correction import Correction
from station.exports.offset_and_scale import effects_lost


def text(correction: Correction) -> str:
    """Return an imu_calib.yaml.

    Raises
    ------
    DataRefused
        If the accelerometers are not calibrated.
    """
    if (triad := correction.accelerometer) is None:
        raise DataRefused("--to imu_calib", None, "no accelerometer", "one: it corrects no gyroscope", "take c")
    SM = np.linalg.inv(triad.matrix)
    said = ["imu_calib of ROS: corrected = SM raw - bias, m/s2, accelerometers", *correction.remarks]
    said.append(f"accelerometer: counts to m/s2 by the nominal scale factor {triad.nominal}")
    said += effects_lost(correction, takes_temperature=False)
    if correction.gyroscope is not None:
        said.append("NOT CARRIED: the gyroscopes; its node uses their mean at start as their bias")
    rows = [("SM", SM.ravel()), ("bias", SM @ triad.offset)]
    lines = [f"# {line}" for line in said]
    for name, values in rows:
        lines += [f"{name}:", *(f"  - {value:.17g}" for value in values)]
    return "\n".join([*lines, ""])
