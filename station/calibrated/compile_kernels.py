"""Compile the kernels that apply a calibration once, at the install.

``python -m station.calibrated.compile_kernels``.
"""

import numpy as np

from station.calibrated.calibration_applied import CalibrationModel
from station.calibrated.surroundings import Surroundings


def compile_all() -> None:
    """Apply a calibration without errors to twenty samples."""
    triad = {"scale_factor": {"value": [1.0] * 3}, "misalignment": {"value": np.eye(3).tolist()},
             "bias": {"value": [0.0] * 3}}  # fmt: skip
    model = CalibrationModel.of({"accelerometer": triad, "gyroscope": triad, "effects": []})
    nothing = np.zeros((20, 3))
    model.inputs(nothing, nothing, Surroundings(temperature=np.full(20, 25.0), t=np.arange(20.0)))


if __name__ == "__main__":
    compile_all()
