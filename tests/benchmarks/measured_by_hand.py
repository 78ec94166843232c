"""Print what a diagnosis makes of measured recordings without a thermometer, beside polynomials of time by hand.

`python -m tests.benchmarks.measured_by_hand` (`STATION_DATA`). A sequence is nine numbers, ``|A (y - b)| = 1`` at
its rests, times 1 (constant) or a polynomial of the rest's time; each rest is left out in turn. A soak is a
polynomial of time a channel, ten blocks or more, of 100 s at most; 100 s at most are left out. Rests
and blocks are cut as the station cuts them, so that both are judged on the same; the fits are of numpy and scipy.
What a search of the library proposes is printed with the errors of its rows left out, without it and with it.
"""

from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from procedures.arrays import FloatArray, IntArray
from procedures.counts.sample_records import RateSeries
from procedures.rests_and_moves.norm_fit import choose_rests
from procedures.rests_and_moves.rest_detection import scatter_level
from tests.benchmarks.foreign_logs import COLUMNS, LSB
from tests.benchmarks.thermal import diagnosed, left_out, powers
from tests.paths import DATA

HELD_OUT = ("held_out_before", "held_out_after")
BY_HAND = {"constant": 0, "linear": 1, "cubic": 3}
MPU = DATA / "foreign/tomisuarez_mpu6050"
SEQUENCES = (
    *((DATA / f"foreign/mikoff_imu_calib/imu{i}.log", COLUMNS) for i in range(5)),
    (MPU / "example_data_calibration.csv", LSB),
    (DATA / "measured/xsens_mti/sequence.csv", ()),
)
SOAKS = ((MPU / "example_data_tinit_calc.csv", LSB),)
BENCHES = tuple(
    (DATA / "measured" / name, ("--partial",))
    for name in ("imucal_six_faces", "ln100_two_positions", "fog_rate_temperature")
)


def samples(log: Path) -> tuple[FloatArray, FloatArray]:
    """Return accelerometers and gyroscopes (n, 3), in the log's units, 100 rows a second."""
    if log.suffix == ".log":
        table = np.loadtxt(log)
    else:
        lines = log.read_text(encoding="utf-8").splitlines()
        begin = next(i for i, line in enumerate(lines) if "ax" in line)
        table = np.loadtxt(lines[begin + 1 :], delimiter=",")
        order = [lines[begin].strip().split(",").index(name) for name in ("ax", "ay", "az", "gx", "gy", "gz")]
        table = table[:, order]
    return table[:, :3], table[:, 3:]


def rests(log: Path) -> tuple[FloatArray, FloatArray]:
    """Return mean outputs (n, 3) and middle times (n,) [s] of a sequence's rests."""
    accel, gyro = samples(log)
    t = np.arange(len(accel)) / 100
    series = RateSeries(t, gyro, accel, np.full(len(t), np.nan), 0.01, np.zeros(1, np.int64))
    stretches = choose_rests(scatter_level(series), 1.0)[1]
    return np.array([accel[each].mean(axis=0) for each in stretches]), np.array([t[s].mean() for s in stretches])


def of_rests(y: FloatArray, t: FloatArray, degree: int) -> float:
    """Return the rms error [ug] of the norm at rests left out in turn; y (n, 3), t (n,) [s].

    nan where fewer are left than there are numbers to fit.
    """
    if len(y) - 1 < 9 + degree:
        return float("nan")
    middle = (y.max(axis=0) + y.min(axis=0)) / 2
    size = float(np.median(np.linalg.norm(y - middle, axis=1)))
    u, time = (y - middle) / size, powers(t, degree)[:, 1:]

    def off(x: FloatArray, rows: IntArray) -> FloatArray:
        A = np.zeros((3, 3))
        A[np.triu_indices(3)] = x[:6]
        found: FloatArray = np.linalg.norm((u[rows] - x[6:9]) @ A.T, axis=1) * (1 + time[rows] @ x[9:]) - 1
        return found

    first = np.concatenate((np.eye(3)[np.triu_indices(3)], np.zeros(3 + degree)))
    everything = np.arange(len(u))
    x = least_squares(off, first, args=(everything,), method="trf", xtol=1e-14, ftol=1e-14).x
    error = [
        off(least_squares(off, x, args=(np.delete(everything, i),), xtol=1e-14, ftol=1e-14).x, np.array([i]))[0]
        for i in everything
    ]
    return 1e6 * float(np.sqrt(np.mean(np.square(error))))


def of_soak(log: Path, degree: int) -> tuple[float, float]:
    """Return the rms errors, ug and deg/h, of blocks left out."""
    found = list[float]()
    for values, unit in zip(samples(log), (1e6 / 16384, 3600 / 131), strict=True):
        several = max(1, int(1e4 * 10 / len(values)))
        blocks = np.array_split(values, max(int(np.ceil(len(values) / 1e4)), min(10, len(values) // 3000)))
        means, number = np.array([block.mean(axis=0) for block in blocks]), np.arange(len(blocks))
        found.append(unit * left_out(powers(number * 1.0, degree), means, number // several))
    return found[0], found[1]


def main() -> None:
    """Print some lines for each recording."""
    for log, options in (*SEQUENCES, *SOAKS, *BENCHES):
        found = diagnosed(log, *options, "--discover")
        proposed = [one for one in found["findings"] if one["confidence"] == "proposed"]
        effects = ", ".join(f"{one['effect']} ({one['confidence']})" for one in found["findings"])
        print(f"{log.parent.name}/{log.name}: {found['verdict']}: {effects or 'nothing named'}")
        print(f"    {found.get('searched', {}).get('terms', 0)} terms, {len(proposed)} proposed")
        for one in proposed:
            print(f"    {' & '.join(one['term'])}, {one['readings_in_all']} readings: {one['held_out_sigmas']}")
        for error in (each for each in found["error"] if HELD_OUT[0] in each):
            values = [1e6 * error[key] if error["unit"] == "g" else error[key] for key in HELD_OUT]
            print(f"    {error['quantity']}: left out {values[0]:.4g} -> {values[1]:.4g}")
        if (log, options) in SOAKS:
            print("    by hand", {name: np.round(of_soak(log, n), 1).tolist() for name, n in BY_HAND.items()})
        elif (log, options) in SEQUENCES:
            y, t = rests(log)
            print(
                f"    by hand, {len(y)} rests", {name: round(of_rests(y, t, n), 1) for name, n in BY_HAND.items()}
            )


if __name__ == "__main__":
    main()
