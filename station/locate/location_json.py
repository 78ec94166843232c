"""A location as `location/1` (docs/reference/file-formats.md): JSON-ready; what is not estimated is absent."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import Trajectory
from station.locate.result import Alignment, Located, WheelFound

FORMAT = "location/1"


def location_document(located: Located, source: str, truth: Trajectory | None) -> dict[str, Any]:
    """Return ``location/1``; ``error_m`` are over all poses from the moment of initialisation."""
    document = {
        "format": FORMAT,
        "source": source,
        "layers": located.layers,
        "initialised_at_s": located.begun_at,
        "why_not": located.why_not or None,
        "alignment": located.alignment and _alignment(located.alignment),
        "gyro_bias_rad_s": _list(located.gyro_bias),
        "accel_bias_m_s2": _list(located.accel_bias),
        "lever_arm_m": _list(located.lever_arm),
        "time_offset_s": located.time_offset,
        "camera_time_offset_s": located.camera_time_offset,
        "camera_time_offset_std_s": located.camera_time_offset_std,
        "wheel": located.wheel and _wheel(located.wheel),
        "rejected_fixes": located.rejected,
        "solve_ms": _times(located),
        "error_m": truth and _errors(located, truth),
        "warnings": list(located.warnings),
    }
    return {name: part for name, part in document.items() if part is not None and part != {}}


def _alignment(alignment: Alignment) -> dict[str, Any]:
    std = {"yaw_deg": alignment.yaw_std_deg, "tilt_deg": alignment.tilt_std_deg}
    value = {"yaw_deg": alignment.yaw_deg, "tilt_deg": alignment.tilt_deg}
    known = {name: part for name, part in value.items() if part is not None}
    return {**known, "std": {name: part for name, part in std.items() if part is not None}}


def _wheel(wheel: WheelFound) -> dict[str, Any]:
    slips = [[begin, end] for begin, end in wheel.slips]
    return {"scale": wheel.scale, "scale_std": wheel.scale_std, "slips_s": slips, "at_rest_s": wheel.rest_s}


def _list(vector: Any) -> list[float] | None:
    return None if vector is None else [float(part) for part in vector]


def _times(located: Located) -> dict[str, float]:
    if not len(located.seconds):
        return {}
    return {"mean": float(np.mean(located.seconds) * 1e3), "worst": float(np.max(located.seconds) * 1e3)}


def _errors(located: Located, truth: Trajectory) -> dict[str, Any]:
    parts = {"online": located.online, "batch": located.smoothed}
    errors = {name: position_errors(part, truth) for name, part in parts.items()}
    return {name: {"mean": off.mean, "max": off.worst} for name, off in errors.items() if off is not None}


@dataclass(frozen=True, slots=True)
class PositionErrors:
    """How far poses are from the truth [m], as they are, without any alignment; of those that it spans."""

    mean: float
    worst: float


def position_errors(trajectory: Trajectory, truth: Trajectory, after: float = -np.inf) -> PositionErrors | None:
    """Return the errors of the poses later than ``after`` [s]; None where the truth spans none."""
    distance = distances(trajectory, truth)[trajectory.t > after]
    distance = distance[np.isfinite(distance)]
    return PositionErrors(float(distance.mean()), float(distance.max())) if len(distance) else None


def distances(trajectory: Trajectory, truth: Trajectory) -> FloatArray:
    """Return the distance (n,) [m] of each pose from the truth, nan where that does not reach."""
    at = np.stack([np.interp(trajectory.t, truth.t, truth.p[:, i], np.nan, np.nan) for i in range(3)], axis=1)
    distance: FloatArray = np.linalg.norm(trajectory.p - at, axis=1)
    return distance
