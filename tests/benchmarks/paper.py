"""Tables 4 to 6 of Yao, Hu, He 2018 out of integer counts, and the bias on a random tilted cube.

The paper's unit and cube, 12 dwells of 100 s at 50 Hz, 10 ug per sample; then the same with random faces and
surface plate of 5e-5 rad.
"""

from dataclasses import replace
from functools import partial

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import P1_THETA, Truth, paper_truth
from procedures.calibration.joint_calibration import solve
from tests.proof.evidence import Figure, spread

TILT = 5e-5  # rad
BOUND = 1e-5 / np.sqrt(5000) / 2  # g: 10 ug, 5000 samples, four dwells


def unit(seed: int, paper_cube: bool) -> Truth:
    """Return the paper's unit on the paper's cube, or on a random one on a tilted slab."""
    truth = paper_truth()
    if paper_cube:
        return truth
    rng = np.random.default_rng([seed, 1])
    return replace(
        truth, faces_rad=TILT * rng.standard_normal((6, 2)), slab_tilt_rad=TILT * rng.standard_normal(2)
    )


def errors(seed: int, paper_cube: bool) -> np.ndarray:
    """Return bias errors (4, 3) [g]: 12-position, two-direction, joint, last-minus-first two-direction."""
    truth = unit(seed, paper_cube)
    campaign = simulate_campaign(truth, seed, turns=(), gravity_std=1e-8)
    solution = solve([campaign]).accelerometer
    assert solution is not None
    assert solution.bias_12_position is not None
    assert solution.bias_two_direction is not None
    counts = np.array([d.series.accel.sum(axis=0) / 100 for d in campaign.dwells])  # type: ignore[union-attr]
    plain = np.array([counts[4 * axis : 4 * axis + 4, axis].mean() for axis in range(3)]) / truth.accel_k
    found = (solution.bias_12_position.value, solution.bias_two_direction.value, solution.bias.value, plain)
    return np.array(found) - truth.accel_d_g


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return bias errors of the estimators on both cubes, and the bound of the noise."""
    result = {"what the noise alone allows": Figure(1e6 * BOUND, "ug")}
    for paper_cube, cube in ((True, "the paper's cube"), (False, "a random tilted cube")):
        found = np.array(spread(partial(errors, paper_cube=paper_cube), range(seed, seed + size), 4))
        rms = 1e6 * np.sqrt(np.mean(found**2, axis=(0, 2)))
        if paper_cube:
            ratio = found[:, 0].mean(axis=0) / np.sin(P1_THETA) / [5 / 3, 2 / 3, 1]
            off = Figure(100 * float(np.max(np.abs(ratio - 1))), "%", at_most=2.0)
            result["12-position error against (5/3, 2/3, 1) sin theta, largest difference"] = off
            result["two-direction error, largest"] = Figure(
                1e6 * float(np.abs(found[:, 1]).max()), "ug", at_most=1.3
            )
        result[f"{cube}: bias of the fit, rms"] = Figure(
            float(rms[2]), "ug", at_most=0.085 + 0.4 * 0.085 / size**0.5
        )
        result[f"{cube}: by last-minus-first counting, rms"] = Figure(float(rms[3]), "ug")
    return result
