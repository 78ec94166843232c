"""Random samples given to an exported program and to the library: how far apart what they make of them is."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from station import cli
from station.calibration import calibration_of
from tests.station.calibrated.test_calibration_applied import D_A, D_G, E_A, E_G, K_A, K_G
from tests.station.exports.c_program import compiled

MAGNETIC = tuple(f"magnetic_ut[{i}]" for i in range(3))
DT = 1 / 64  # s, which float and sums of it hold exactly


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Counts (n, 6) each ``interval`` [s], T (n,) [degC], field (n, 3) [uT]: numbers that float holds, too."""

    counts: FloatArray
    T: FloatArray
    field: FloatArray
    interval: float

    @property
    def dt(self) -> FloatArray:
        return np.full(len(self.T), self.interval)

    @property
    def t(self) -> FloatArray:
        return np.arange(1, len(self.T) + 1) * self.interval


@dataclass(frozen=True, slots=True)
class Apart:
    """The largest error of force and of rate as a part of the vector's length, and what the self-test says."""

    force: float
    rate: float
    self_test: float


def random_samples(n: int, seed: int, interval: float = DT) -> Samples:
    """Draw specific forces up to 5 g, rates up to 400 deg/s an axis, temperatures between 6 and 44 degC."""
    rng = np.random.default_rng(seed)
    t = np.arange(n) * interval
    T = (25 + 12 * np.sin(t / 61) + 6 * np.sin(t / 17 + 1)).astype(np.float32).astype(np.float64)
    f, omega = rng.uniform(-5, 5, (n, 3)), rng.uniform(-400, 400, (n, 3))
    read = np.hstack((K_G * (omega @ E_G.T + D_G / 3600), K_A * (f @ E_A.T + D_A)))
    field = rng.uniform(-50, 50, (n, 3)).astype(np.float32).astype(np.float64)
    return Samples(np.round(read * interval), T, field, interval)


def by_library(document: dict[str, Any], samples: Samples) -> tuple[FloatArray, FloatArray]:
    """Return force [m/s2] and rate [rad/s] (n, 3) as the library has them."""
    found = calibration_of(document).apply(
        samples.counts, samples.t, samples.T, magnetic=samples.field, period=samples.interval
    )
    assert all("to the campaign" in each for each in found.warnings)
    return found.specific_force, found.angular_rate


def apart(document: dict[str, Any], folder: Path, samples: Samples, *, is_float: bool) -> Apart:
    """Export, compile, run and compare."""
    (folder / "calibration.json").write_text(json.dumps(document))
    number = "--float" if is_float else "--double"
    assert cli.run(["export", str(folder / "calibration.json"), "--to", "c", number, "--out", str(folder)]) == 0
    program = compiled(folder, "fog_imu", is_float=is_float, inputs=MAGNETIC)
    found = program.apply(samples.counts, samples.T, samples.dt, samples.field)
    errors = [
        float((np.linalg.norm(mine - true, axis=1) / np.linalg.norm(true, axis=1)).max())
        for mine, true in zip((found[:, :3], found[:, 3:]), by_library(document, samples), strict=True)
    ]
    return Apart(*errors, program.self_test())
