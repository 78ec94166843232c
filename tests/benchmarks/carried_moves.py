"""Twelve placings and the moves between them, no turn: errors of the gyroscopes against their sigma.

``python -m tests.benchmarks.carried_moves --trials 50 --order quarter_and_half``
"""

import argparse
import time

import numpy as np

from procedures.calibration.triad_calibration import triad_vector
from procedures.dwells_and_turns.gyroscopes_joint_fit import solve_gyroscope
from procedures.dwells_and_turns.twelve_position import solve_accelerometer
from procedures.frames import POSITIONS
from tests.procedures.dwells_and_turns.carried_cube import campaign

ORDERS = {
    "paper": POSITIONS,
    "quarter_and_half": tuple("ENU ESD USE DSW SUW NDW NWU SWD UWS DES EUS EDN".split()),
    "half": tuple("ENU ESD WND WSU UEN DWN DSW USE NUE NDW SDE SUW".split()),
    "planned": tuple("USE DNE DSW WND ENU ESD EUS WDS WSU WUN UWS DWN".split()),  # by `station plan`
}
OFF_DIAGONAL = [4, 5, 6, 8, 9, 10]  # of E, in k, E, D
PPM, ARCSEC = 1e6, 180 * 3600 / np.pi


def main() -> None:
    """Draw campaigns and print a table of errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=20)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--order", choices=ORDERS, default="quarter_and_half")
    parser.add_argument("--seconds", type=float, default=25.0, help="of a move")
    asked = parser.parse_args()
    errors, ratios, spent = [], [], []
    for seed in range(asked.first, asked.first + asked.trials):
        made = campaign(seed, ORDERS[asked.order], seconds=asked.seconds)
        begin = time.process_time()
        accelerometer = solve_accelerometer([made.campaign], made.accelerometer)
        fit = solve_gyroscope([made.campaign], made.gyroscope, [], accelerometer)
        spent.append(time.process_time() - begin)
        if fit is None:
            raise SystemExit(f"seed {seed}: not solved")
        vector = triad_vector(fit.joint, "gyroscope", accelerometer)
        errors.append(vector.value - made.truth)
        ratios.append(errors[-1] / np.sqrt(np.diag(vector.covariance)))
        errors[-1][:3] *= PPM / made.truth[:3]
    print(f"{asked.order}: {asked.trials} campaigns, moves of {asked.seconds:g} s")
    print("            rms error   rms of error / sigma   within 1.96 sigma")
    groups = (("k, ppm", [0, 1, 2], 1.0), ("E, arcsec", OFF_DIAGONAL, ARCSEC), ("D, deg/h", [12, 13, 14], 1.0))
    for name, rows, unit in groups:
        off, told = np.array(errors)[:, rows] * unit, np.array(ratios)[:, rows]
        held = np.mean(np.abs(told) < 1.96)
        print(f"{name:10s} {np.sqrt(np.mean(off**2)):10.4f} {np.sqrt(np.mean(told**2)):14.2f} {held:20.1%}")
    print(f"processor time of a solve: {np.median(spent):.2f} s")


if __name__ == "__main__":
    main()
