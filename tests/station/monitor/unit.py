"""A simulated unit whose calibration is its truth, served on a pty."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from drivers.simulated.truth import Truth

G = 9.80665
STD = {"k": 1e-6, "e": 1e-6, "accel": 1e-5, "gyro": 0.01}  # relative, rad, g, deg/h


def calibration_of(truth: Truth) -> dict[str, Any]:
    """Return calibration/1 as if a campaign had found the truth."""
    return {
        "format": "calibration/1", "model": truth.model, "serial": truth.serial, "software": "test",
        "status": "calibrated", "accepted_utc": "2026-11-01T12:00:00Z", "valid_from": "2026-11-01T12:00:00Z",
        "effects": [], "inputs": {}, "previous": "0" * 64,
        "accelerometer": _triad(truth.accel_k, truth.accel_e, truth.accel_d_g, STD["accel"], "count/(g s)", "g"),
        "gyroscope": _triad(truth.gyro_k, truth.gyro_e, truth.gyro_d_deg_s * 3600, STD["gyro"], "count/deg",
                            "deg/h"),
    }  # fmt: skip


def _triad(k: Any, E: Any, D: Any, bias: float, k_unit: str, d_unit: str) -> dict[str, Any]:
    def part(value: Any, std: Any, unit: str) -> dict[str, Any]:
        return {"value": value.tolist(), "std": np.broadcast_to(std, value.shape).tolist(), "unit": unit}

    return {
        "scale_factor": part(k, np.abs(k) * STD["k"], k_unit),
        "misalignment": part(E, STD["e"], "1"),
        "bias": part(D, bias, d_unit),
    }


def write_calibration(folder: Path, truth: Truth) -> Path:
    """Write it to a file and return its path."""
    path = folder / "calibration.json"
    path.write_text(json.dumps(calibration_of(truth)), encoding="utf-8")
    return path
