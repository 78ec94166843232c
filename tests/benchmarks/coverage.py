"""How often 95 % intervals cover the truth: 1.96 u of the solution, and value +- U of the budget.

Every campaign is another unit on another cube and surface plate, all tilted; gravity, headings, closures and,
where given, face certificates are drawn from the sigmas that the campaign states. The budget is that of exact
latitude and time base, as the simulation has them.
"""

from functools import partial

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import fit, report
from procedures.calibration.solution_values import Estimate
from procedures.frames import AXES
from procedures.uncertainty.budget import ParameterBudget, budget
from procedures.uncertainty.sources import EXACT
from tests.proof.evidence import Figure, spread

CERTIFICATE = 5e-6  # rad
OFF_DIAGONAL = ~np.eye(3, dtype=bool)
NORMAL_95 = 1.959964
EXPANDED = " by U"
BIAS_ERROR = "accelerometer bias, rms error"


def errors(seed: int, certified: bool) -> dict[str, np.ndarray]:
    """Return the error of every parameter in its own sigma, and of some in natural units."""
    truth = Truth.example(seed)
    campaign = simulate_campaign(truth, seed, certificate_sigma=CERTIFICATE if certified else None)
    fits = fit([campaign])
    solution, budgets = report(fits), {one.name: one for one in budget(fits, EXACT)}
    accel, gyro = solution.accelerometer, solution.gyroscope
    found = {
        "accelerometer k": in_sigma(accel.scale_factor, truth.accel_k),
        "accelerometer D": in_sigma(accel.bias, truth.accel_d_g),
        "gyroscope k": in_sigma(gyro.scale_factor, truth.gyro_k),
        "gyroscope D": in_sigma(gyro.bias, truth.gyro_d_deg_s * 3600),
        BIAS_ERROR: 1e6 * (accel.bias.value - truth.accel_d_g),
    }
    found["parallelism"] = in_sigma(solution.parallelism, truth.faces_rad.reshape(3, 2, 2).sum(axis=1)).ravel()
    found["slab tilt"] = in_sigma(solution.slab_tilt, truth.slab_tilt_rad)
    if certified:
        found["accelerometer E"] = in_sigma(accel.misalignment, truth.accel_e)[OFF_DIAGONAL]
        found["gyroscope E"] = in_sigma(gyro.misalignment, truth.gyro_e)[OFF_DIAGONAL]
    return found | expanded(found, budgets)


def expanded(found: dict[str, np.ndarray], budgets: dict[str, ParameterBudget]) -> dict[str, np.ndarray]:
    """Return what of ``found`` has a budget, in units of U / 1.96: inside as often as U covers the truth."""
    parts = {"k": "scale_factor", "D": "bias", "E": "misalignment"}
    result = dict[str, np.ndarray]()
    for name, z in found.items():
        triad, _, letter = name.partition(" ")
        if letter in parts:
            indices = AXES if letter != "E" else [q + p for q in AXES for p in AXES if p != q]
            factors = [budgets[f"{triad}.{parts[letter]}.{i}"].coverage_factor for i in indices]
            result[name + EXPANDED] = z * NORMAL_95 / np.array(factors)
    return result


def in_sigma(estimate: Estimate, truth: np.ndarray) -> np.ndarray:
    """Return the error in units of its own sigma; diagonals of E have none to speak of."""
    return (estimate.value - truth) / np.maximum(estimate.std, 1e-300)


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return the share covered of each kind of parameter, without and with certified faces."""
    result = dict[str, Figure]()
    for certified, title in ((False, "no certificate"), (True, "faces certified")):
        rows = spread(partial(errors, certified=certified), range(seed, seed + size), 4)
        found = {name: np.stack([row[name] for row in rows]) for name in rows[0]}
        for name, z in found.items():
            is_error = name == BIAS_ERROR
            result[f"{name}, {title}"] = Figure(np.sqrt(np.mean(z**2)), "ug") if is_error else covered(z)
    return result


def covered(z: np.ndarray) -> Figure:
    """Return the share inside 95 % of errors (campaigns, parameters); asked: 95 % +- 4 sigma."""
    off = 4 * 100 * float(np.sqrt(0.95 * 0.05 / len(z)))
    return Figure(100 * np.mean(np.abs(z) < NORMAL_95), "%", round(min(95 + off, 100), 1), round(95 - off, 1))
