"""How far a trajectory is from the truth: position errors as they are, without any alignment."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import Trajectory


@dataclass(frozen=True, slots=True)
class Errors:
    """Position errors [m] over the poses that the truth spans."""

    mean: float
    worst: float


def errors(trajectory: Trajectory, truth: Trajectory, after: float = -np.inf) -> Errors | None:
    """Return the errors of the poses later than ``after`` [s]; None where the truth spans none."""
    distance = distances(trajectory, truth)[trajectory.t > after]
    distance = distance[np.isfinite(distance)]
    return Errors(float(distance.mean()), float(distance.max())) if len(distance) else None


def distances(trajectory: Trajectory, truth: Trajectory) -> FloatArray:
    """Return the distance (n,) [m] of each pose from the truth, nan where that does not reach."""
    at = np.stack([np.interp(trajectory.t, truth.t, truth.p[:, i], np.nan, np.nan) for i in range(3)], axis=1)
    distance: FloatArray = np.linalg.norm(trajectory.p - at, axis=1)
    return distance
