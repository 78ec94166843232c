"""What is exported, applied as the receiver applies it to a simulated unit's counts, gives the true input back."""

import json
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import SimulatedBench
from drivers.simulated.truth import Truth
from fixtures_db.hash_chain import GENESIS
from fixtures_db.stored_calibrations import calibration_document
from procedures.arrays import FloatArray
from procedures.calibration.solution_values import Estimate, FitQuality, Solution, TriadCalibration
from procedures.campaign.plan_steps import Dwell
from procedures.geodesy import earth_rate_n
from procedures.positions import face_normal, face_of, nominal_C_lb
from procedures.units import STANDARD_GRAVITY
from station import cli
from station.exports import EXPORTS, Export, Request
from tests.fixtures_db.factory import facts

SECONDS = 200.0
NOMINAL = (1000.0, 36000.0)
CORRECTIONS = [export for export in EXPORTS if export.name in {"ardupilot", "px4", "kalibr"}]
every_export = pytest.mark.parametrize("export", CORRECTIONS, ids=lambda export: export.name)
Correct = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


def unit(misaligned: bool = False) -> Truth:
    truth = Truth.example(3)
    quiet = replace(truth, accel_noise_g=0.0, gyro_arw_deg_rt_s=0.0, gyro_instability_dph=0.0, settle_rad=0.0)
    level = replace(quiet, faces_rad=np.zeros((6, 2)), slab_tilt_rad=np.zeros(2), heading_std_deg=0.0)
    return level if misaligned else replace(level, accel_e=np.eye(3), gyro_e=np.eye(3))


def calibration_file(path: Path, truth: Truth) -> Path:
    """Write a unit's truth as its calibration."""

    def exact(value: FloatArray, unit: str) -> Estimate:
        return Estimate(value, np.full(value.shape, 1e-9), unit)

    triads = (
        TriadCalibration(
            exact(truth.accel_k, "count/(g s)"), exact(truth.accel_e, "1"), exact(truth.accel_d_g, "g")
        ),
        TriadCalibration(
            exact(truth.gyro_k, "count/deg"), exact(truth.gyro_e, "1"), exact(truth.gyro_d_deg_s * 3600, "deg/h")
        ),
    )
    solution = Solution(*triads, None, None, FitQuality(1.0, 1, 0.5), (), np.zeros((0, 0)), 23.0)
    path.write_text(json.dumps(calibration_document(solution, facts(), GENESIS)))
    return path


def readings(truth: Truth, position: int) -> tuple[FloatArray, FloatArray]:
    """Return what a driver with nominal scale factors reads at rest (m/s2, rad/s), from simulated counts."""
    series = SimulatedBench(truth, None).perform(Dwell(position, SECONDS))
    assert series.accel is not None
    assert series.gyro is not None
    accel, gyro = (counts.sum(axis=0) / SECONDS for counts in (series.accel, series.gyro))
    return accel / NOMINAL[0] * STANDARD_GRAVITY, np.radians(gyro / NOMINAL[1])


def true_input(truth: Truth, position: int) -> tuple[FloatArray, FloatArray]:
    C_bl = nominal_C_lb(position).T
    rate: FloatArray = C_bl @ earth_rate_n(np.radians(truth.latitude_deg))
    return face_normal(face_of(position)) * truth.local_gravity, rate


def as_ardupilot(text: str) -> Correct:
    rows = dict(line.split(",") for line in text.splitlines() if line and not line.startswith("#"))
    offset, scale, gyro = (
        np.array([float(rows[f"INS_{name}_{axis}"]) for axis in "XYZ"])
        for name in ("ACCOFFS", "ACCSCAL", "GYROFFS")
    )
    return lambda accel, rate: ((accel - offset) * scale, rate - gyro)


def as_px4(text: str) -> Correct:
    rows = [line.split("\t") for line in text.splitlines() if line and not line.startswith("#")]
    assert all(row[0] == row[1] == "1" and row[4] == "9" and len(row) == 5 for row in rows)
    value = {row[2]: float(row[3]) for row in rows}
    offset = np.array([value[f"CAL_ACC0_{axis}OFF"] for axis in "XYZ"])
    scale = np.array([value[f"CAL_ACC0_{axis}SCALE"] for axis in "XYZ"])
    gyro = np.array([value[f"CAL_GYRO0_{axis}OFF"] for axis in "XYZ"])
    return lambda accel, rate: ((accel - offset) * scale, rate - gyro)


def as_kalibr(text: str) -> Correct:
    triads = re.split(r"^\w+scopes:|^accelerometers:", text, flags=re.M)[1:]
    found = [[json.loads(row) for row in re.findall(r"\[.*\]", triad)] for triad in triads]
    (accel_M, accel_b), (gyro_M, gyro_b) = ((np.array(rows[:3]), np.array(rows[3])) for rows in found)
    return lambda accel, rate: (np.linalg.solve(accel_M, accel - accel_b), np.linalg.solve(gyro_M, rate - gyro_b))


READ = {"ardupilot": as_ardupilot, "px4": as_px4, "kalibr": as_kalibr}


def text_of(export: Export, path: Path, *nominal: float) -> str:
    (content,) = export.files(Request(path, *nominal)).values()
    return content.decode()


@dataclass(frozen=True)
class Error:
    accel: float  # m/s2
    gyro: float  # rad/s


def error_of(export: Export, truth: Truth, path: Path) -> tuple[Error, str]:
    text = text_of(export, calibration_file(path / "calibration.json", truth), *NOMINAL)
    correct, accel, gyro = READ[export.name](text), list[float](), list[float]()
    for position in range(1, 13):
        found, true = correct(*readings(truth, position)), true_input(truth, position)
        accel.append(float(np.abs(found[0] - true[0]).max()))
        gyro.append(float(np.abs(found[1] - true[1]).max()))
    return Error(max(accel), max(gyro)), text


COUNT = Error(
    1.01 * STANDARD_GRAVITY / (0.9 * NOMINAL[0] * SECONDS), np.radians(1.01 / (0.9 * NOMINAL[1] * SECONDS))
)


@every_export
def test_the_true_input_is_recovered_to_a_count(export: Export, tmp_path: Path) -> None:
    truth = unit()
    if export.name != "kalibr":  # neither flight stack scales gyros
        truth = replace(truth, gyro_k=np.full(3, NOMINAL[1]))
    error, _ = error_of(export, truth, tmp_path)
    assert error.accel < COUNT.accel
    assert error.gyro < COUNT.gyro
    bias = np.abs(truth.accel_d_g).max() * STANDARD_GRAVITY
    assert bias > 20 * COUNT.accel  # else an offset left out would not show
    assert np.abs(truth.gyro_d_deg_s).max() > np.degrees(20 * COUNT.gyro)


@every_export
def test_what_is_not_carried_is_reported_and_bounds_the_error(export: Export, tmp_path: Path) -> None:
    truth = unit(misaligned=True)
    error, text = error_of(export, truth, tmp_path)
    if export.name == "kalibr":
        assert error.accel < COUNT.accel
        assert "misalignment up to" not in text
        return
    found = re.search(r"# NOT CARRIED: accelerometer misalignment up to ([\d.]+) mrad: ([\d.]+) mg error", text)
    assert found is not None
    assert error.accel < float(found[2]) * 1e-3 * STANDARD_GRAVITY + COUNT.accel
    assert error.accel > 0.3 * float(found[2]) * 1e-3 * STANDARD_GRAVITY
    for what in ("gyroscope misalignment", "gyroscope scale factor", "the uncertainties"):
        assert f"# NOT CARRIED: {what}" in text


@every_export
def test_the_command_writes_the_file(export: Export, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = calibration_file(tmp_path / "calibration.json", unit())
    command = ["export", str(path), "--to", export.name, "--nominal-accel", "1000"]
    assert cli.run(command) == 0
    printed = capsys.readouterr().out
    assert cli.run([*command, "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out").read_text() == printed == text_of(export, path, 1000.0)
