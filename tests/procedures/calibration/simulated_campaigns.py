"""Simulated campaigns for tests of the calibration."""

from dataclasses import replace
from functools import cache

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.calibration.solution_values import Estimate, Solution
from procedures.campaign.campaign import Campaign

OFF = ~np.eye(3, dtype=bool)
Z = FloatArray


def fine(seed: int) -> Truth:
    truth = Truth.example(seed)
    return replace(truth, accel_k=1e5 * truth.accel_k, gyro_k=1e3 * truth.gyro_k)


def simulated(truth: Truth, seed: int, **options: object) -> Campaign:
    return simulate_campaign(truth, seed, dwell_s=20.0, **options)  # type: ignore[arg-type]


@cache
def usual() -> tuple[Truth, Campaign]:
    truth = fine(3)
    return truth, simulated(truth, 3)


def z(estimate: Estimate, truth: FloatArray) -> Z:
    return (estimate.value - truth) / np.maximum(estimate.std, 1e-300)


def scores(solution: Solution, truth: Truth, misalignment: bool = False) -> Z:
    """Errors of everything both triads claim, in their own sigma."""
    found = []
    for triad, k, E, D in (
        (solution.accelerometer, truth.accel_k, truth.accel_e, truth.accel_d_g),
        (solution.gyroscope, truth.gyro_k, truth.gyro_e, truth.gyro_d_deg_s * 3600),
    ):
        if triad is not None:
            found += [z(triad.scale_factor, k), z(triad.bias, D)]
            found += [z(triad.misalignment, E)[OFF]] if misalignment else []
    return np.concatenate(found)
