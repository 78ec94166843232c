"""Files for ROS: Kalibr's imu.yaml and the accelerometers of imu_calib.

Kalibr: ``measured = M truth + bias``, the scale-misalignment model. ethz-asl/kalibr,
aslam_offline_calibration/kalibr/python/kalibr_imu_camera_calibration/IccSensors.py,
``IccScaledMisalignedImu``: accelerometer ``M (C_i_b f) + b``, gyroscope ``M (C_gyro_i C_i_b w) + A (...) + b``, in
m/s2 and rad/s; the file's keys are ``accelerometers: M`` and ``gyroscopes: M, A, C_gyro_i``. Kalibr itself
estimates a lower-triangular M and puts the rest into C_gyro_i; here M is full and C_gyro_i the identity, as both
triads share the body axes. It treats biases as unknown and has no key for them: ``bias`` is for other readers.

imu_calib of ROS: ``corrected = SM raw - bias`` in m/s2, of the accelerometers alone.
dpkoch/imu_calib, src/accel_calib/accel_calib.cpp, ``applyCalib`` and ``loadCalib``: keys SM, nine numbers row by
row, and bias, three. Its node apply_calib takes the mean of the gyroscopes while it starts as their bias, unless
``calibrate_gyros`` is false, and corrects nothing else of them.
"""

import numpy as np

from station.errors import DataRefused
from station.exports.correction import Correction, effects_lost


def kalibr_text(correction: Correction) -> str:
    """Return an imu.yaml."""
    nominal = {
        "accelerometers": ("m/s2", correction.accelerometer),
        "gyroscopes": ("rad/s", correction.gyroscope),
    }
    lines = ["# Kalibr imu.yaml, model scale-misalignment: measured = M truth + bias"]
    lines += [f"# {line}" for line in correction.remarks]
    lines += [f"# {line}" for line in effects_lost(correction, takes_temperature=False)]
    lines += [f"# {name}: counts to {unit} by {t.nominal}" for name, (unit, t) in nominal.items() if t is not None]
    lines += [f"# {line}" for line in _WARNINGS]
    lines.append("model: scale-misalignment")
    for name, (_, triad) in nominal.items():
        if triad is not None:
            matrix = [f"  - {_row(row)}" for row in triad.matrix]
            lines += [f"{name}:", "  M:", *matrix, f"  bias: {_row(triad.offset)}"]
            lines += _GYROSCOPE if name == "gyroscopes" else []
    return "\n".join([*lines, ""])


def _row(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> str:
    return f"[{', '.join(f'{value:.12g}' for value in values)}]"


_GYROSCOPE = [
    "  A:",
    *["  - [0.0, 0.0, 0.0]"] * 3,
    "  C_gyro_i:",
    "  - [1.0, 0.0, 0.0]",
    "  - [0.0, 1.0, 0.0]",
    "  - [0.0, 0.0, 1.0]",
]
_WARNINGS = (
    "NOT CARRIED: noise densities and random walks, which a calibration does not hold; Kalibr wants them:",
    "accelerometer_noise_density, accelerometer_random_walk, gyroscope_noise_density, gyroscope_random_walk,",
    "update_rate and rostopic. The report's Allan deviation has the noise.",
)


def imu_calib_text(correction: Correction) -> str:
    """Return an imu_calib.yaml; raise `DataRefused` if the accelerometers are not calibrated."""
    if (triad := correction.accelerometer) is None:
        raise DataRefused("--to imu_calib", None, "no accelerometer", "one: it corrects no gyroscope", "take c")
    SM = np.linalg.inv(triad.matrix)
    texts = ["imu_calib of ROS: corrected = SM raw - bias, m/s2, accelerometers", *correction.remarks]
    texts.append(f"accelerometer: counts to m/s2 by the nominal scale factor {triad.nominal}")
    texts += effects_lost(correction, takes_temperature=False)
    if correction.gyroscope is not None:
        texts.append("NOT CARRIED: the gyroscopes; its node uses their mean at start as their bias")
    rows = [("SM", SM.ravel()), ("bias", SM @ triad.offset)]
    lines = [f"# {line}" for line in texts]
    for name, values in rows:
        lines += [f"{name}:", *(f"  - {value:.17g}" for value in values)]
    return "\n".join([*lines, ""])
