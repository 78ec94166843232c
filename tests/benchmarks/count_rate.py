"""Print how good a dwell's rate is: `python -m tests.benchmarks.count_rate --dwells 400`.

Dwells of 5000 samples with white rate noise, the noise estimated from the dwell itself ("alone") or shared by
twelve dwells of one channel ("twelve"), as a campaign does. rms is the error's over what the noise alone allows
if the output were seen without counting; error/sigma is the rms of the error in the estimate's own sigma. Beside
it, the same figures of the least-squares slope through the cumulative count with white remainder, and of
last-minus-first counting.
"""

import argparse
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from procedures.counts.count_rate import estimate_counts

SAMPLES, PERIOD = 5000, 0.02
NOISES = (1e-4, 2e-4, 1e-3, 1e-2, 0.1, 1.0, 100.0)  # counts per sample
RATES: dict[str, Callable[[np.random.Generator], float]] = {
    "20-21 a sample": lambda rng: 20 + rng.random(),
    "60-500 a dwell": lambda rng: rng.uniform(60, 500) / SAMPLES,
    "20-60 a dwell": lambda rng: rng.uniform(20, 60) / SAMPLES,
    "8-20 a dwell": lambda rng: rng.uniform(8, 20) / SAMPLES,
    "4-8 a dwell": lambda rng: rng.uniform(4, 8) / SAMPLES,
    "2-4 a dwell": lambda rng: rng.uniform(2, 4) / SAMPLES,
}


def dwell(rng: np.random.Generator, rate: float, noise: float) -> np.ndarray:
    """Return the increments of one dwell of an integrate-and-fire counter."""
    output = rng.random() + np.concatenate(([0.0], np.cumsum(rate + noise * rng.standard_normal(SAMPLES))))
    return np.diff(np.floor(output)).astype(np.int64)


def slope(increments: np.ndarray) -> float:
    """Return the least-squares slope of the cumulative count, counts per sample."""
    t = np.arange(SAMPLES + 1) - SAMPLES / 2
    return float(t @ np.concatenate(([0], np.cumsum(increments))) / (t @ t))


def errors(seed: int, name: str, noise: float, together: int) -> np.ndarray:
    """Return (together, 4): errors of estimate, slope and last-minus-first over the bound; error over sigma."""
    rng = np.random.default_rng([seed, round(noise * 1e6), len(name)])
    rates = [RATES[name](rng) for _ in range(together)]
    dwells = [dwell(rng, rate, noise) for rate in rates]
    bound = noise / np.sqrt(SAMPLES)
    rows = []
    for rate, increments, found in zip(rates, dwells, estimate_counts(dwells, PERIOD), strict=True):
        error = found.rate * PERIOD - rate
        plain = increments.mean() - rate
        rows.append(
            (error / bound, (slope(increments) - rate) / bound, plain / bound, error / (found.std * PERIOD))
        )
    return np.array(rows)


def main() -> None:
    """Print a line per noise and rate."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--dwells", type=int, default=400)
    dwells = parser.parse_args().dwells
    columns = ("rms", "e/s", "rms 12", "e/s 12", "slope", "first-last")
    print(f"{'noise':>8s} {'counts':16s}" + "".join(f"{name:>11s}" for name in columns))
    with ProcessPoolExecutor(2) as pool:
        for noise in NOISES:
            for name in RATES:
                cells = []
                for together in (1, 12):
                    n = max(dwells // together, 1)
                    parts = pool.map(errors, range(n), [name] * n, [noise] * n, [together] * n, chunksize=4)
                    cells.append(np.sqrt(np.mean(np.vstack(list(parts)) ** 2, axis=0)))
                (rms, straight, plain, over), (rms12, _, _, over12) = cells
                figures = (rms, over, rms12, over12, straight, plain)
                print(f"{noise:8g} {name:16s}" + "".join(f"{x:11.2f}" for x in figures), flush=True)


if __name__ == "__main__":
    main()
