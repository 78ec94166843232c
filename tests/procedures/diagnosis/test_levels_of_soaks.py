"""Several rests at one temperature each: their means tell a slope, a jump, a bias that is new each time."""

from pathlib import Path

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign

SECONDS, RATE = 400, 10
N = SECONDS * RATE
TEMPERATURES = (20.0, 50.0, -20.0, 35.0, 0.0)
SLOPE = np.array([10.0, -5.0, 2.0])  # deg/h/K
OFF = np.array([150.0, -220.0, 60.0, 90.0, -80.0])  # deg/h, as drawn at turn-on


def diagnosed(
    folder: Path, biases: FloatArray, *, moved: bool = False, accel_z: FloatArray | None = None
) -> Diagnosis:
    """Diagnose a log for each of the gyroscopes' biases (m, 3) [deg/h], at an attitude of its own if ``moved``."""
    rng, files = np.random.default_rng(7), list[str]()
    for i, bias in enumerate(biases):
        up = rng.standard_normal(3) if moved else np.array([0.02, -0.01, 1.0])
        earth = 15.04 * (rng.standard_normal(3) if moved else np.array([0.5, 0.5, 0.7]))
        gyro = (bias + earth / np.linalg.norm(earth) * 15.04) / 3600 + 0.035 * rng.standard_normal((N, 3))
        accel = up / np.linalg.norm(up) + 3e-4 * rng.standard_normal((N, 3))
        accel[:, 2] += 0.0 if accel_z is None else accel_z[i]
        temperature = TEMPERATURES[i] + 0.02 * rng.standard_normal(N)
        table = np.column_stack([gyro, accel, temperature])
        files.append(str(folder / f"log{i}.csv"))
        np.savetxt(files[-1], table, "%.9g", ",", header="gx,gy,gz,ax,ay,az,T", comments="")
    options = ["--gyro", "gx,gy,gz", "--accel", "ax,ay,az", "--unit-gyro", "deg/s", "--unit-accel", "g"]
    options += ["--rate", str(RATE), "--temperature", "T", "--as", "soak", "--campaign", str(folder / "c")]
    assert cli.run(["diagnose", *files, *options]) == 0
    return diagnose([read_campaign(folder / "c").campaign])


@pytest.mark.parametrize("moved", [True])
def test_a_slope_by_temperature_is_told_by_rests_at_one_temperature_each(tmp_path: Path, moved: bool) -> None:
    found = diagnosed(tmp_path, np.outer(np.array(TEMPERATURES) - 25, SLOPE), moved=moved)
    (finding,) = found.findings
    assert finding.effect == "gyroscope.bias_temperature"
    assert np.all(np.abs(finding.value - SLOPE) < 4 * finding.std)
    assert np.all(finding.std < 0.3)
    (error,) = (each for each in found.errors if each.quantity == "gyroscope soaks beside each other")
    assert error.held_out_before is not None
    assert error.held_out_after is not None
    assert error.held_out_after < 0.1 * error.held_out_before


def test_a_bias_that_is_new_at_each_turn_on_is_named_and_its_sigma_told(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, np.stack([OFF, np.roll(OFF, 2), np.roll(OFF, 3)], axis=1))
    (finding,) = found.findings
    assert (finding.effect, finding.coefficients) == ("gyroscope.turn_on_bias", ("value",))
    assert finding.value[0] == pytest.approx(float(np.std(OFF, ddof=1)), rel=0.35)


def test_a_jump_between_two_rests_is_named(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, np.outer(np.arange(5) >= 2, [0.0, 100.0, 0.0]))
    (finding,) = found.findings
    assert finding.effect == "gyroscope.jump"
    assert finding.value[1] == pytest.approx(100, abs=4 * finding.std[1])


@pytest.mark.parametrize("moved", [True])
def test_rests_that_differ_by_their_attitude_alone_are_consistent(tmp_path: Path, moved: bool) -> None:
    found = diagnosed(tmp_path, np.zeros((5, 3)), moved=moved)
    assert not found.findings
    assert found.verdict == "consistent"
