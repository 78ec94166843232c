"""Brisk flips by a trembling hand: the error of the integrated rotation against the part of sigma stated for it.

``python -m tests.benchmarks.hand_moves --trials 500 --seconds 4 --hz 100``
"""

import argparse
import time

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.counts.sample_records import RateSeries
from procedures.dwells_and_turns.brisk_moves import MAX_CONING_RAD
from procedures.dwells_and_turns.finer_moves import finer_moves
from procedures.frames import rotation_vector
from tests.procedures.dwells_and_turns.carried_cube import carried

ARCSEC = 180 * 3600 / np.pi


def move(seed: int, seconds: float, hz: float, fine: int = 2400) -> tuple[RateSeries, np.ndarray]:
    """Return the rates [deg/s] of a flip by 180 deg about a random level axis, and its rotation (3, 3).

    Neither counts nor noise: what is left is the error of the integration.
    """
    rng = np.random.default_rng(seed)
    begin = Rotation.random(random_state=rng)
    heading = rng.uniform(0, 2 * np.pi)
    end = Rotation.from_rotvec(np.pi * np.array([np.cos(heading), np.sin(heading), 0.0])) * begin
    steps = carried(begin, end, seconds, hz, rng, fine, per_sample=False)
    truth = Rotation.from_rotvec(-steps).as_matrix()
    while len(truth) > 1:
        truth = np.concatenate((truth, np.eye(3)[None])) if len(truth) % 2 else truth
        truth = truth[1::2] @ truth[::2]
    # what a gyroscope integrates is not the rotation vector: less what even these steps cone
    turned = steps - np.cross(np.vstack((steps[:1], steps[:-1])), steps) / 12
    samples = turned.reshape(-1, round(fine / hz), 3).sum(axis=1)
    t = np.arange(1.0, len(samples) + 1) / hz
    return RateSeries(t, np.degrees(samples) * hz, None, np.full(len(t), np.nan), 1 / hz), truth[0]


def errors(seeds: range, seconds: float, hz: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the errors (n, 3) [rad] of n moves and 1 sigma (n,) [rad] stated of each component."""
    made = [move(seed, seconds, hz) for seed in seeds]
    moves, at = finer_moves([series for series, _ in made]), (np.eye(3), np.zeros(3))
    truth = np.stack([each for _, each in made])
    return rotation_vector(truth @ np.swapaxes(moves.integrate(*at).rotation, 1, 2)), moves.coning(*at)


def main() -> None:
    """Draw moves and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=200)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--seconds", type=float, nargs="*", default=[4.0, 8.0, 25.0])
    parser.add_argument("--hz", type=float, nargs="*", default=[50.0, 100.0, 200.0])
    asked = parser.parse_args()
    begin = time.process_time()
    print(f"{asked.trials} flips by a hand that trembles by 20 to 60 deg/s at 2 to 8 Hz, arcsec")
    print("  s a flip      Hz   rms error   median sigma   within 1.96 sigma   too brisk")
    for seconds in asked.seconds:
        for hz in asked.hz:
            off, told = errors(range(asked.first, asked.first + asked.trials), seconds, hz)
            held = np.mean(np.abs(off) < 1.96 * told[:, None])
            row = (np.sqrt(np.mean(off**2)) * ARCSEC, np.median(told) * ARCSEC)
            brisk = np.mean(told > MAX_CONING_RAD)
            print(f"{seconds:10.1f} {hz:7.0f} {row[0]:11.5f} {row[1]:14.5f} {held:19.1%} {brisk:11.1%}")
    print(f"{time.process_time() - begin:.0f} s of processor time")


if __name__ == "__main__":
    main()
