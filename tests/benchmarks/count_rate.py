"""How good a dwell's rate is, beside the slope of the cumulative count and last-minus-first counting.

Dwells of 5000 samples of an integrate-and-fire counter with white rate noise, twelve dwells of one channel sharing
their noise, as in a campaign. Errors are in what the noise alone allows if the output were seen without counting.
"""

from collections.abc import Callable

import numpy as np

from procedures.counts.count_rate import estimate_counts
from tests.proof.evidence import Figure, spread

SAMPLES, PERIOD, TOGETHER = 5000, 0.02, 12
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


def errors(item: tuple[int, str, float]) -> np.ndarray:
    """Return (12, 4): errors of estimate, slope and last-minus-first over the bound; error over sigma."""
    seed, name, noise = item
    rng = np.random.default_rng([seed, round(noise * 1e6), len(name)])
    rates = [RATES[name](rng) for _ in range(TOGETHER)]
    dwells = [dwell(rng, rate, noise) for rate in rates]
    bound, rows = noise / np.sqrt(SAMPLES), []
    for rate, increments, found in zip(rates, dwells, estimate_counts(dwells, PERIOD), strict=True):
        error = found.rate * PERIOD - rate
        plain = increments.mean() - rate
        rows.append(
            (error / bound, (slope(increments) - rate) / bound, plain / bound, error / (found.std * PERIOD))
        )
    return np.array(rows)


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return rms errors for each noise, over all rates, and how honest the sigma is."""
    result = dict[str, Figure]()
    for noise in NOISES:
        items = [(seed + i, name, noise) for name in RATES for i in range(max(size // TOGETHER, 1))]
        rms, straight, plain, over = np.sqrt(np.mean(np.vstack(spread(errors, items, 4)) ** 2, axis=0))
        result[f"noise of {noise:g} counts: rms over the bound"] = Figure(float(rms))
        result[f"noise of {noise:g} counts: of the slope"] = Figure(float(straight))
        result[f"noise of {noise:g} counts: of last-minus-first"] = Figure(float(plain))
        result[f"noise of {noise:g} counts: error over sigma, rms"] = Figure(float(over))
    return result
