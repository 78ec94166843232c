"""What follows from not knowing which of two: the solution with the one widened by that with the other.

A seating and that of its pair's other position fit equally well but move parallelism, and with it misalignment,
in opposite ways. Of two solutions x and y, each as likely, the second moment about x is
``C + (y - x) (y - x)^T / 2``.
"""

from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.solution_values import Estimate, Solution, TriadCalibration
from procedures.calibration.triad_calibration import vector_names


def widened_by_alternative(one: Solution, other: Solution) -> Solution:
    """Return ``one`` with sigmas and covariance that hold ``other`` for as likely."""
    step = _values(other) - _values(one)
    return replace(
        one,
        accelerometer=_triad(one.accelerometer, other.accelerometer),
        gyroscope=_triad(one.gyroscope, other.gyroscope),
        slab_tilt=_estimate(one.slab_tilt, other.slab_tilt),
        parallelism=_estimate(one.parallelism, other.parallelism),
        covariance=one.covariance + np.outer(step, step) / 2,
    )


def _triad(one: TriadCalibration | None, other: TriadCalibration | None) -> TriadCalibration | None:
    return one if one is None or other is None else one.widened((other.vector - one.vector) / np.sqrt(2))


def _estimate(one: Estimate | None, other: Estimate | None) -> Estimate | None:
    return one if one is None or other is None else one.widened((other.value - one.value) / np.sqrt(2))


def _values(solution: Solution) -> FloatArray:
    """Return the values of ``solution.names``, in that order."""
    known = dict[str, float]()
    for triad in ("accelerometer", "gyroscope"):
        found = getattr(solution, triad)
        if found is not None:
            known |= zip(vector_names(triad), found.vector.tolist(), strict=True)
    bench = [each.value.ravel() for each in (solution.slab_tilt, solution.parallelism) if each is not None]
    names = [name for name in solution.names if name not in known]
    known |= zip(names, np.concatenate([*bench, np.zeros(0)]).tolist(), strict=True)
    return np.array([known[name] for name in solution.names])
