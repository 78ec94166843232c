"""Print how often 95 % intervals cover the truth: `python -m tests.benchmarks.coverage --campaigns 1000`.

Both kinds of interval: 1.96 sigma of the solution, and value +- U of the budget, whose coverage factor knows the
degrees of freedom. The budget is that of exact latitude and time base, as the simulation has them.

Every campaign is another unit on another cube and slab, all tilted; gravity, headings, closures and, where
given, face certificates are drawn from the sigmas that the campaign states.
"""

import argparse

import numpy as np

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import fit, report
from procedures.calibration.solution_values import Estimate
from procedures.frames import AXES
from procedures.uncertainty.budget import ParameterBudget, budget
from procedures.uncertainty.given_values import EXACT
from tests.benchmarks.monte_carlo import add_options, draws

CERTIFICATE = 5e-6  # rad
OFF_DIAGONAL = ~np.eye(3, dtype=bool)
NORMAL_95 = 1.959964
EXPANDED = " by U"
POOLED, SINGLE = (94.0, 96.0), (92.9, 97.1)


def errors(seed: int, certified: bool) -> dict[str, np.ndarray]:
    """Return the error of every parameter in its own sigma, and of some in natural units."""
    truth = Truth.example(seed)
    campaign = simulate_campaign(truth, seed, certificate_sigma=CERTIFICATE if certified else None)
    fits = fit([campaign])
    solution, budgets = report(fits), {one.name: one for one in budget(fits, EXACT)}
    accel, gyro = solution.accelerometer, solution.gyroscope
    assert accel is not None
    assert gyro is not None
    found = {
        "accelerometer k": in_sigma(accel.scale_factor, truth.accel_k),
        "accelerometer D": in_sigma(accel.bias, truth.accel_d_g),
        "gyroscope k": in_sigma(gyro.scale_factor, truth.gyro_k),
        "gyroscope D": in_sigma(gyro.bias, truth.gyro_d_deg_s * 3600),
        "accelerometer D error, g": accel.bias.value - truth.accel_d_g,
        "gyroscope k error, ppm": (gyro.scale_factor.value / truth.gyro_k - 1) * 1e6,
        "gyroscope D error, deg/h": gyro.bias.value - truth.gyro_d_deg_s * 3600,
    }
    assert solution.parallelism is not None
    assert solution.slab_tilt is not None
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


def drawn(item: tuple[int, bool]) -> dict[str, list[float]]:
    """Return `errors` of a seed, certified or not, as JSON can hold them."""
    return {name: found.tolist() for name, found in errors(*item).items()}


def run(campaigns: int, certified: bool, options: argparse.Namespace) -> dict[str, np.ndarray]:
    """Return `errors` of all campaigns, stacked."""
    items = [(seed, certified) for seed in range(campaigns)]
    rows = draws("tests.benchmarks.coverage", "drawn", items, options)
    return {name: np.stack([row[name] for row in rows]) for name in rows[0]}


def table(found: dict[str, np.ndarray], title: str) -> bool:
    """Print a line per parameter; return whether all lie inside their limits."""
    good = True
    print(f"{title}\n{'parameter':20s} {'pooled %':>9s} {'single % (worst)':>17s} {'rms/sigma':>10s}")
    for name, z in found.items():
        if "error" in name:
            print(f"{name:34s} rms {np.sqrt(np.mean(z**2)):.4g}")
            continue
        inside = np.abs(z) < NORMAL_95
        single = 100 * inside.mean(axis=0)
        pooled = 100 * inside.mean()
        worst = single[np.argmax(np.abs(single - 95))]
        good &= POOLED[0] <= pooled <= POOLED[1] and SINGLE[0] <= single.min() and single.max() <= SINGLE[1]
        spread = "" if name.endswith(EXPANDED) else f"{np.sqrt(np.mean(z**2)):10.3f}"
        print(f"{name:20s} {pooled:9.2f} {worst:17.1f} {spread}")
    return good


def main() -> None:
    """Run with and without a certificate."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=1000)
    add_options(parser)
    options = parser.parse_args()
    campaigns = options.campaigns
    good = [
        table(
            run(campaigns, certified, options),
            f"{campaigns} campaigns, {'faces certified' if certified else 'no certificate'}",
        )
        for certified in (False, True)
    ]
    print(f"limits: pooled {POOLED} %, single {SINGLE} %: {'all inside' if all(good) else 'some outside'}")


if __name__ == "__main__":
    main()
