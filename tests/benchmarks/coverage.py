"""Print how often 95 % intervals cover the truth: `python -m tests.benchmarks.coverage --campaigns 1000`.

Every campaign is another unit on another cube and slab, all tilted; gravity, headings, closures and, where
given, face certificates are drawn from the sigmas that the campaign states.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from drivers.simulated.bench import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration import solve
from procedures.solution import Estimate

CERTIFICATE = 5e-6  # rad
CHUNK = 4
OFF_DIAGONAL = ~np.eye(3, dtype=bool)
POOLED, SINGLE = (94.0, 96.0), (92.9, 97.1)


def errors(seed: int, certified: bool) -> dict[str, np.ndarray]:
    """Return the error of every parameter in its own sigma, and of some in natural units."""
    truth = Truth.example(seed)
    campaign = simulate_campaign(truth, seed, certificate_sigma=CERTIFICATE if certified else None)
    solution = solve([campaign])
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
    return found


def in_sigma(estimate: Estimate, truth: np.ndarray) -> np.ndarray:
    """Return the error in units of its own sigma; diagonals of E have none to speak of."""
    return (estimate.value - truth) / np.maximum(estimate.std, 1e-300)


def run(campaigns: int, certified: bool, processes: int = 2) -> dict[str, np.ndarray]:
    """Return `errors` of all campaigns, stacked."""
    with ProcessPoolExecutor(processes) as pool:
        rows = list(pool.map(errors, range(campaigns), [certified] * campaigns, chunksize=CHUNK))
    return {name: np.stack([row[name] for row in rows]) for name in rows[0]}


def table(found: dict[str, np.ndarray], title: str) -> bool:
    """Print a line per parameter; return whether all lie inside their limits."""
    good = True
    print(f"{title}\n{'parameter':18s} {'pooled %':>9s} {'single % (worst)':>17s} {'rms/sigma':>10s}")
    for name, z in found.items():
        if "error" in name:
            print(f"{name:34s} rms {np.sqrt(np.mean(z**2)):.4g}")
            continue
        inside = np.abs(z) < 1.959964
        single = 100 * inside.mean(axis=0)
        pooled = 100 * inside.mean()
        worst = single[np.argmax(np.abs(single - 95))]
        good &= POOLED[0] <= pooled <= POOLED[1] and SINGLE[0] <= single.min() and single.max() <= SINGLE[1]
        print(f"{name:18s} {pooled:9.2f} {worst:17.1f} {np.sqrt(np.mean(z**2)):10.3f}")
    return good


def main() -> None:
    """Run with and without a certificate."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=1000)
    campaigns = parser.parse_args().campaigns
    good = [
        table(
            run(campaigns, certified),
            f"{campaigns} campaigns, {'faces certified' if certified else 'no certificate'}",
        )
        for certified in (False, True)
    ]
    print(f"limits: pooled {POOLED} %, single {SINGLE} %: {'all inside' if all(good) else 'some outside'}")


if __name__ == "__main__":
    main()
