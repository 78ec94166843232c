"""Twelve placings and the moves between them: errors of gyroscopes and cube by sigma.

``python -m tests.benchmarks.carried_moves --trials 50 --order quarter_and_half``; six hand turns follow
with ``--closure 0.05`` [deg].
"""

import argparse
import time

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.triad_calibration import triad_vector
from procedures.campaign.observations import turn_totals
from procedures.dwells_and_turns.gyroscopes_joint_fit import GyroscopeFit, solve_gyroscope
from procedures.dwells_and_turns.twelve_position import solve_accelerometer
from procedures.frames import POSITIONS
from tests.procedures.dwells_and_turns.carried_cube import Carried, campaign

ORDERS = {
    "paper": POSITIONS,
    "quarter_and_half": tuple("ENU ESD USE DSW SUW NDW NWU SWD UWS DES EUS EDN".split()),
    "half": tuple("ENU ESD WND WSU UEN DWN DSW USE NUE NDW SDE SUW".split()),
    "twelve": tuple("WND NWU SUW WDS NUE DNE UEN DSW ESD EDN UWS SEU".split()),  # the best of the paper's twelve
    "planned": tuple("USE DNE DSW WND ENU ESD EUS WDS WSU WUN UWS DWN".split()),  # by `station plan`
}
OFF_DIAGONAL = [4, 5, 6, 8, 9, 10]  # of E, in k, E, D
PPM, ARCSEC = 1e6, 180 * 3600 / np.pi
LEAST_SIGMA = 1e-30  # of an element of E that is one by definition
GROUPS = (
    ("k, ppm", [0, 1, 2], 1.0),
    ("E, arcsec", OFF_DIAGONAL, ARCSEC),
    ("D, deg/h", [12, 13, 14], 1.0),
    ("skew, arcsec", [15, 16, 17], ARCSEC),
    ("slab, arcsec", [18, 19], ARCSEC),
)


def main() -> None:
    """Draw campaigns and print a table of errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--order", choices=ORDERS, default="quarter_and_half")
    parser.add_argument("--seconds", type=float, default=25.0, help="of a move")
    parser.add_argument("--closure", type=float, help="1 sigma of turns [deg]; none without")
    asked = parser.parse_args()
    closure = None if asked.closure is None else float(np.radians(asked.closure))
    errors, ratios, spent = [], [], []
    for seed in range(asked.first, asked.first + asked.trials):
        made = campaign(seed, ORDERS[asked.order], seconds=asked.seconds, closure=closure)
        begin = time.process_time()
        accelerometer = solve_accelerometer([made.campaign], made.accelerometer)
        turns = turn_totals([made.campaign], made.gyroscope.noise)
        fit = solve_gyroscope([made.campaign], made.gyroscope, turns, accelerometer)
        spent.append(time.process_time() - begin)
        if fit is None:
            raise SystemExit(f"seed {seed}: not solved")
        vector = triad_vector(fit.joint, "gyroscope", accelerometer)
        error = vector.value - made.truth
        cube, cube_std = bench_errors(made, fit)
        std = np.sqrt(np.diag(vector.covariance))
        ratios.append(np.concatenate((error / np.maximum(std, LEAST_SIGMA), cube / cube_std)))
        error[:3] *= PPM / made.truth[:3]
        errors.append(np.concatenate((error, cube)))
    turned = "no turn" if closure is None else f"turns that close to {asked.closure:g} deg"
    print(f"{asked.order}: {asked.trials} campaigns, moves of {asked.seconds:g} s, {turned}")
    print("                       rms error   rms of error / sigma   within 1.96 sigma")
    for name, rows, unit in GROUPS:
        off, told = np.array(errors)[:, rows] * unit, np.array(ratios)[:, rows]
        held = np.mean(np.abs(told) < 1.96)
        print(f"{name:20s} {np.sqrt(np.mean(off**2)):11.4f} {np.sqrt(np.mean(told**2)):14.2f} {held:20.1%}")
    told = np.array(ratios)[:, [row for _, rows, _ in GROUPS for row in rows]]
    print(f"all of these within 1.96 sigma: {np.mean(np.abs(told) < 1.96):.1%}")
    print(f"processor time of a solve: {np.median(spent):.2f} s")


def bench_errors(made: Carried, fit: GyroscopeFit) -> tuple[FloatArray, FloatArray]:
    """Return errors (5,) [rad] of the cube's three skews and of the slab's tilt, and 1 sigma of each."""
    bench, x = fit.joint.bench, fit.joint.fit.x[12:]
    J = np.zeros((5, len(x)))
    first = bench.cube_slice(0).start + 6  # q: x.y x.z y.x y.z z.x z.y
    for row, (a, b) in enumerate(((0, 2), (1, 4), (3, 5))):
        J[row, [first + a, first + b]] = 1
    J[3:, :2] = np.eye(2)
    error: FloatArray = J @ x - np.concatenate((made.skew, made.slab))
    std: FloatArray = np.sqrt(np.diag(J @ fit.joint.fit.covariance[12:, 12:] @ J.T))
    return error, std


if __name__ == "__main__":
    main()
