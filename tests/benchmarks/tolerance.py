"""Print how long a million cubes take, and how far the exact formulas are from the simulated station.

`python -m tests.benchmarks.tolerance`: P1's unit and drawing. Drawn cubes go through all three estimators on one
core; then some of them through the simulator, integer counts and `solve`, whose scatter is that of 100 s dwells.
"""

import argparse
import time
from dataclasses import replace

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import paper_truth
from procedures.calibration.joint_calibration import solve
from procedures.tolerance.drawing_items import ITEMS, angles
from procedures.tolerance.estimator_errors import ESTIMATOR_NAMES, ToleranceUnit, estimator_errors
from procedures.tolerance.monte_carlo import draw_errors, draw_tilts

ITEM = angles(dict.fromkeys(ITEMS, 0.04), 400.0)
TRUTH = paper_truth()
UNIT = ToleranceUnit(
    TRUTH.accel_e / np.linalg.norm(TRUTH.accel_e, axis=1, keepdims=True), TRUTH.accel_d_g, np.zeros(3)
)


def simulated(tilts: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the bias errors (3, 3) [g] of the station's own solve on a cube of ``tilts`` (6, 2), and 1 sigma."""
    campaign = simulate_campaign(replace(TRUTH, faces_rad=tilts), seed, turns=(), gravity_std=1e-8)
    found = solve([campaign]).accelerometer
    assert found is not None
    assert found.bias_12_position is not None
    assert found.bias_two_direction is not None
    parts = (found.bias_12_position, found.bias_two_direction, found.bias)
    return np.array([part.value for part in parts]) - TRUTH.accel_d_g, np.array([part.std for part in parts])


def main() -> None:
    """Print both."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cubes", type=int, default=1_000_000)
    parser.add_argument("--simulated", type=int, default=20)
    options = parser.parse_args()
    for directions in ("any", "p1"):
        begin, used = time.perf_counter(), time.process_time()
        sample = draw_errors(ITEM, UNIT, options.cubes, 1, directions=directions)  # type: ignore[arg-type]
        seconds, used = time.perf_counter() - begin, time.process_time() - used
        print(
            f"{options.cubes} cubes, directions {directions}: {seconds:.2f} s, {used:.2f} s of a core  (asked: 10)"
        )
        for name, bias in zip(ESTIMATOR_NAMES, sample.bias, strict=True):
            print(f"  {name:7} rms {np.sqrt(np.mean(bias**2, axis=1)) * 1e6} ug")
    tilts = draw_tilts(np.random.default_rng(2), ITEM, options.simulated)
    predicted = estimator_errors(tilts, UNIT).bias
    found, std = (
        np.stack(part, axis=2)
        for part in zip(*(simulated(tilts[..., i], i) for i in range(options.simulated)), strict=True)
    )
    print(f"simulated less predicted, {options.simulated} cubes, integer counts, in the solve's own sigma")
    for name, off, sigma in zip(ESTIMATOR_NAMES, found - predicted, std, strict=True):
        rms = np.sqrt(np.mean((off / sigma) ** 2))
        print(f"  {name:7} rms {rms:.2f}, median sigma {np.median(sigma) * 1e6:.3f} ug")


if __name__ == "__main__":
    main()
