"""A recording of counts in every form that is read, and the calibration of its unit."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from procedures.counts.sample_records import CountBlock
from station.files.mcap_files.writer import StepWriter
from tests.station.calibrated.test_calibration_applied import D_A, D_G, E_A, E_G, calibration, effect

N, PERIOD = 6000, 0.02
K_A, K_G = np.array([1.01e5, 0.99e5, 1.005e5]), np.array([3.6e5, 3.55e5, 3.63e5])
DRAW = np.random.default_rng(11)
F, OMEGA = DRAW.normal([0.0, 0.1, 1.0], 0.2, (N, 3)), DRAW.uniform(-120, 120, (N, 3))
T_S = np.round(5.0 + PERIOD * np.arange(1, N + 1), 9)
TEMP = np.round(28 + 8 * np.sin(T_S / 15) + 0.3 * np.sin(T_S), 4)
VOLTS = np.round(12 + np.cos(T_S / 7), 3)
OUTPUT = np.hstack((K_G * (OMEGA @ E_G.T + D_G / 3600), K_A * (F @ E_A.T + D_A)))
COUNTS = np.rint(OUTPUT * PERIOD)
NAMES = ("gx", "gy", "gz", "ax", "ay", "az")
COLUMNS: dict[str, np.ndarray] = {"t_s": T_S, **dict(zip(NAMES, COUNTS.T, strict=True)), "temp_c": TEMP,
                                  "aux_volts": VOLTS}  # fmt: skip
EFFECTS = (
    effect("accelerometer.quadratic", x=6e-5, y=-4e-5, z=2e-5), effect("accelerometer.cubic", x=3e-5, z=-1e-5),
    effect("accelerometer.cross_product", xxy=2e-5, yyz=-3e-5), effect("accelerometer.scale_asymmetry", x=90.0),
    effect("accelerometer.bias_temperature", **{"x.1": 1e-5, "x.2": -3e-7, "z.1": -4e-5}),
    effect("accelerometer.scale_temperature", x=20.0, y=30.0, z=-10.0),
    effect("accelerometer.temperature_lag", x=1e-5, y=-2e-5, z=3e-5, tau_s=40.0),
    effect("gyroscope.g_sensitivity", xz=0.7, yy=-0.3),
    effect("gyroscope.scale_nonlinearity", "u |u|", x=2.0, z=-1.0),
    effect("gyroscope.sagnac_sine", x=1e-3, y=2e-3, z=3e-3),
    effect("gyroscope.temperature_rate", x=1.0, y=-1.0, z=2.0),
    effect("gyroscope.scale_temperature_lag", x=50.0, y=-20.0, z=10.0, tau_s=90.0),
    effect("gyroscope.temperature_hysteresis", x=0.5, y=-0.5, z=0.2),
    effect("accelerometer.temperature_hysteresis", "with a play", x=5e-5, y=-8e-5, play_k=1.7),
)  # fmt: skip


def document(*effects: dict[str, Any], unit: str = "count") -> dict[str, Any]:
    found = calibration(*effects) | {"model": "X", "serial": "S1", "temperature_range_c": [10.0, 50.0]}
    for name, k, std in (("accelerometer", K_A, 2e-6), ("gyroscope", K_G, 0.01)):
        per = {"count": {"accelerometer": "count/(g s)", "gyroscope": "count/deg"},
               "output": {"accelerometer": "output/g", "gyroscope": "output/(deg/s)"}}[unit][name]  # fmt: skip
        found[name]["scale_factor"] = {"value": k.tolist(), "std": (1e-5 * k).tolist(), "unit": per}
        found[name]["bias"]["std"] = [std] * 3
        found[name]["misalignment"]["std"] = [[0.0, 2e-5, 2e-5], [2e-5, 0.0, 2e-5], [2e-5, 2e-5, 0.0]]
    return found


def calibration_file(folder: Path, *effects: dict[str, Any], **more: Any) -> Path:
    path = folder / "calibration.json"
    unit = more.pop("unit", "count")
    path.write_text(json.dumps(document(*effects, unit=unit) | more))
    return path


def write_csv(path: Path, columns: dict[str, np.ndarray] = COLUMNS) -> Path:
    rows = zip(*(map(repr, column.tolist()) for column in columns.values()), strict=True)
    path.write_text("\n".join([",".join(columns), *map(",".join, rows)]).replace("nan", "") + "\n")
    return path


def write_npz(path: Path, columns: dict[str, np.ndarray] = COLUMNS) -> Path:
    np.savez(path, **columns)
    return path


def write_compressed(path: Path) -> Path:
    gyro, acc = COUNTS[:, :3].astype(np.int32), COUNTS[:, 3:].T.copy()  # a row a sample, and a row a channel
    np.savez_compressed(path, t_s=T_S, gyro=gyro, acc=acc, temp_c=TEMP, aux_volts=VOLTS)
    return path


def write_parquet(path: Path) -> Path:
    import pyarrow
    import pyarrow.parquet as parquet

    parquet.write_table(pyarrow.table(COLUMNS), path, row_group_size=777)
    return path


def write_mat(path: Path) -> Path:
    from scipy.io import savemat

    savemat(path, {name: column[:, None] for name, column in COLUMNS.items()})
    return path


def write_mcap(path: Path) -> Path:
    writer = StepWriter(path)
    zeros = np.zeros(N, np.int64)
    block = CountBlock(
        np.arange(N), T_S, COUNTS[:, :3].astype(np.int64), COUNTS[:, 3:].astype(np.int64), TEMP, zeros, zeros == 0
    )
    writer.write_block(1, block)
    writer.close()
    return path


def write_campaign(
    folder: Path, *, output: str = "increments", period: float = PERIOD, serial: str = "S1"
) -> Path:
    """A campaign of two dwells, each half of the samples, the later one first in its file."""
    folder.mkdir()
    half, columns = N // 2, dict(COLUMNS)
    if output == "cumulative":
        running = (np.cumsum(COUNTS, axis=0) + 2**15) % 2**24 - 0
        columns |= dict(zip(NAMES, running.T, strict=True))
    for name, part in (("b", slice(half, None)), ("a", slice(0, half))):
        cut = {key: column[part] for key, column in columns.items()}
        kinds = {key: column.astype(np.int64) if key in NAMES else column for key, column in cut.items()}
        write_csv(folder / f"{name}.csv", kinds)
    wrap = "wrap_bits = 24\n" if output == "cumulative" else ""
    (folder / "campaign.toml").write_text(
        f'format = "campaign/1"\n[imu]\nmodel = "X"\nserial = "{serial}"\nsample_period_s = {period}\n'
        f'output = "{output}"\n{wrap}[fixture]\nimu_axes = ["+y", "-x", "+z"]\n'
        '[[sequence]]\nfile = "b.csv"\n[[sequence]]\nfile = "a.csv"\n'
    )
    return folder
