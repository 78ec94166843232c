"""Print what a line of time does for biases that walk at random, and what a diagnosis names in them.

`python -m tests.benchmarks.bias_walk [--count N]`. The recordings are as long and as noisy as the still MPU-6050
of `tests.benchmarks.measured_by_hand`, made by numpy alone: white noise; a walk of the size that was found in it;
a line of the slope that was found. Of each ten blocks, a constant, a line and a walk (the best linear prediction
of known sizes) foretell one that is left out, and the ten blocks of the next 449 s.
"""

import argparse
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from tests.benchmarks.thermal import diagnosed

SECONDS, RATE, BLOCKS = 449, 10, 10
WALK_PER_ROOT_HOUR = np.array([5.4e-4] * 3 + [73.0] * 3)  # g, deg/h
LINE_PER_HOUR = np.array([2e-4, -9e-4, 4.2e-3, -112.0, -208.0, -454.0])
WHITE = np.array([3.26e-4, 3.01e-4, 4.60e-4, 26.9, 40.0, 33.7]) * np.sqrt(
    RATE
)  # of a sample: 1 s is this / sqrt(RATE)
LSB = ("--rate", str(RATE), "--unit-gyro", "131/(deg/s)", "--unit-accel", "16384/g", "--as", "soak",
       "--accel", "1,2,3", "--gyro", "4,5,6")  # fmt: skip
PER_UNIT = np.array([16384.0] * 3 + [131 / 3600] * 3)


def recording(kind: str, seed: int, seconds: int = SECONDS) -> FloatArray:
    """Return samples (n, 6) [g, deg/h] that are ``white`` noise, or that and a ``walk`` or a ``line``."""
    rng, n = np.random.default_rng(seed), seconds * RATE
    found = WHITE * rng.standard_normal((n, 6))
    if kind == "walk":
        found += np.cumsum(WALK_PER_ROOT_HOUR / np.sqrt(3600 * RATE) * rng.standard_normal((n, 6)), axis=0)
    if kind == "line":
        found += LINE_PER_HOUR * np.arange(n)[:, None] / (3600 * RATE)
    return found


def foretold(kind: str, seed: int, model: str) -> tuple[FloatArray, FloatArray]:
    """Return rms errors (6,) [g, deg/h] in blocks left out in turn and in those of as long afterwards."""
    t = np.arange(2 * BLOCKS) * SECONDS / BLOCKS / 3600
    blocks = recording(kind, seed, 2 * SECONDS).reshape(2 * BLOCKS, -1, 6).mean(axis=1)
    X = np.column_stack((np.ones_like(t), t))[:, : 2 if model == "line" else 1]
    first, left = np.arange(BLOCKS), list[FloatArray]()
    for out in (*np.arange(BLOCKS)[:, None], np.arange(BLOCKS, 2 * BLOCKS)):
        known = np.setdiff1d(first, out)
        said_so = [_at(X, t, known, out, blocks[:, i], model, i) for i in range(6)]
        left.append(blocks[out] - np.column_stack(said_so))
    return np.sqrt(np.mean(np.concatenate(left[:-1]) ** 2, axis=0)), np.sqrt(np.mean(left[-1] ** 2, axis=0))


def _at(
    X: FloatArray, t: FloatArray, known: FloatArray, out: FloatArray, y: FloatArray, model: str, i: int
) -> FloatArray:
    """Return what blocks known say of those left out (m,): generalised least squares and the walk's covariance."""
    walk = WALK_PER_ROOT_HOUR[i] ** 2 * np.minimum.outer(t, t) if model == "walk" else np.zeros((len(t), len(t)))
    V = walk[np.ix_(known, known)] + WHITE[i] ** 2 / (RATE * SECONDS / BLOCKS) * np.eye(len(known))
    W = np.linalg.inv(V)
    x = np.linalg.solve(X[known].T @ W @ X[known], X[known].T @ W @ y[known])
    found: FloatArray = X[out] @ x + walk[np.ix_(out, known)] @ W @ (y[known] - X[known] @ x)
    return found


def said(kind: str, seed: int) -> list[str]:
    """Return what a diagnosis names in a recording."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "log.csv"
        np.savetxt(log, recording(kind, seed) * PER_UNIT, fmt="%.3f", delimiter=",")
        return [f"{each['effect']} ({each['confidence']})" for each in diagnosed(log, *LSB)["findings"]]


def main() -> None:
    """Print a table of predictions and one of names."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=20)
    count = parser.parse_args().count
    for kind in ("white", "walk", "line"):
        constant = np.array([foretold(kind, seed, "constant") for seed in range(count)])
        for model in ("line", "walk"):
            ratio = np.array([foretold(kind, seed, model) for seed in range(count)]) / constant
            for name, one in zip(("left out", "afterwards"), np.swapaxes(ratio, 0, 1), strict=True):
                print(
                    f"{kind}, by a {model}, {name}: {np.median(one):.2f} of a constant's error, "
                    f"better in {np.mean(one < 1):.0%}, worse than 1.5 times in {np.mean(one > 1.5):.0%}"
                )
        print(f"{kind}:", dict(Counter(each for seed in range(count) for each in said(kind, seed))))


if __name__ == "__main__":
    main()
