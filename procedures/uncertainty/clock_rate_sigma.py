"""A solution whose sigmas hold that of the clock's rate by which its times were put right."""

from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.calibration.solution_values import Solution, TriadCalibration
from procedures.calibration.triad_calibration import moves_vector, triad_vector, vector_names
from procedures.dwells_and_turns.latitude_and_time_base import clock_on_accelerometer, clock_on_moves, clock_rows
from procedures.uncertainty.triad_variance import gain_of


def with_clock(solution: Solution, fits: CampaignFits, std: float) -> Solution:
    """Return the solution of these fits, its sigmas and covariance widened by a relative 1 sigma of the clock."""
    shifts = {triad: std * shift for triad, shift in _shifts(fits).items()}
    by_name = dict[str, float]()
    for triad, shift in shifts.items():
        by_name |= zip(vector_names(triad), shift.tolist(), strict=True)
    step = np.array([by_name.get(name, 0.0) for name in solution.names])
    return replace(
        solution,
        accelerometer=_wider(solution.accelerometer, shifts.get("accelerometer")),
        gyroscope=_wider(solution.gyroscope, shifts.get("gyroscope")),
        covariance=solution.covariance + np.outer(step, step),
    )


def _shifts(fits: CampaignFits) -> dict[str, FloatArray]:
    """Return by triad the change of k, E, D (15,) per relative error of the time base."""
    counts, found = fits.campaigns[0].counts, dict[str, FloatArray]()
    joint = fits.accelerometer
    if joint is not None:
        vector = triad_vector(joint, "accelerometer", joint)
        found["accelerometer"] = clock_on_accelerometer(vector.value, counts)
    if fits.gyroscope is not None:
        vector = triad_vector(fits.gyroscope.joint, "gyroscope", joint)
        rows = clock_rows(fits.gyroscope, not counts)
        found["gyroscope"] = vector.jacobian @ (gain_of(fits.gyroscope.joint.fit) @ rows)
    elif fits.moves is not None and joint is not None:
        found["gyroscope"] = clock_on_moves(moves_vector(fits.moves, joint).value, counts)
    return found


def _wider(triad: TriadCalibration | None, shift: FloatArray | None) -> TriadCalibration | None:
    return triad if triad is None or shift is None else triad.widened(shift)
