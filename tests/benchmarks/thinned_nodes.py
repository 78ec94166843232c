"""Print what thinning the nodes of long dwells costs and saves: `python -m tests.benchmarks.thinned_nodes`.

Six dwells of 50,000 samples share a noise; the same counts are estimated with all nodes in doubt and with
`MAX_NODES` of them. A sigma is the mean of those stated, in counts a dwell.
"""

import time

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.counts import count_rate

SAMPLES, DWELLS, CAMPAIGNS = 50_000, 6, 4
NOISES = (3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.25)  # counts/sqrt(sample)


def main() -> None:
    """Print a row per noise."""
    print("| noise | sigma, all | thinned | rms error/sigma, all | thinned | apart, sigma | time, all / thinned |")
    print("|---|---|---|---|---|---|---|")
    thinned = count_rate.MAX_NODES
    for noise in NOISES:
        rng = np.random.default_rng(int(1e5 * noise))
        campaigns = [_campaign(noise, rng) for _ in range(CAMPAIGNS)]
        count_rate.MAX_NODES = SAMPLES + 1
        error, std, took = _estimated(campaigns)
        count_rate.MAX_NODES = thinned
        error_thinned, std_thinned, took_thinned = _estimated(campaigns)
        print(
            f"| {noise:g} | {SAMPLES * np.mean(std):.3f} | {SAMPLES * np.mean(std_thinned):.3f} "
            f"| {_rms(error / std):.2f} | {_rms(error_thinned / std_thinned):.2f} "
            f"| {_rms((error - error_thinned) / std):.3f} | {took / took_thinned:.1f} |",
            flush=True,
        )


def _campaign(noise: float, rng: np.random.Generator) -> tuple[FloatArray, list[IntArray]]:
    rates = rng.uniform(-0.3, 0.3, DWELLS)
    steps = rates[:, None] + noise * rng.standard_normal((DWELLS, SAMPLES))
    output = rng.random((DWELLS, 1)) + np.hstack((np.zeros((DWELLS, 1)), np.cumsum(steps, axis=1)))
    return rates, list(np.diff(np.floor(output), axis=1).astype(np.int64))


def _estimated(campaigns: list[tuple[FloatArray, list[IntArray]]]) -> tuple[FloatArray, FloatArray, float]:
    begin = time.process_time()
    found = [estimate for _, dwells in campaigns for estimate in count_rate.estimate_counts(dwells, 1.0)]
    took = time.process_time() - begin
    true = np.concatenate([rates for rates, _ in campaigns])
    return np.array([e.rate for e in found]) - true, np.array([e.std for e in found]), took


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


if __name__ == "__main__":
    main()
