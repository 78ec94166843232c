"""Kalibr: ``measured = M truth + bias``, the scale-misalignment model of its imu.yaml.

ethz-asl/kalibr, aslam_offline_calibration/kalibr/python/kalibr_imu_camera_calibration/IccSensors.py,
``IccScaledMisalignedImu``: accelerometer ``M (C_i_b f) + b``, gyroscope ``M (C_gyro_i C_i_b w) + A (...) + b``, in
m/s2 and rad/s; the file's keys are ``accelerometers: M`` and ``gyroscopes: M, A, C_gyro_i``. Kalibr itself
estimates a lower-triangular M and puts the rest into C_gyro_i; here M is full and C_gyro_i the identity, as both
triads share the body axes. It treats biases as unknown and has no key for them: ``bias`` is for other readers.
"""

import numpy as np

from station.exports.correction import Correction
from station.exports.offset_and_scale import effects_lost


def text(correction: Correction) -> str:
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
