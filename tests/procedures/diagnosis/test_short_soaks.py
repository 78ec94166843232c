"""What a MEMS gyroscope does by time in a quarter of an hour at rest: jump, drift, settling, random walk."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign

SECONDS, RATE = 900.0, 10
ARW = 0.67 / 60  # deg/sqrt(s)
STEP = 0.03  # deg/s
TIME = np.arange(int(SECONDS * RATE)) / RATE


def diagnosed(folder: Path, of_y: FloatArray, seed: int = 1) -> Diagnosis:
    """Diagnose a soak of noise whose gyroscope y has ``of_y`` (n,) [deg/s] besides, read as a user's table is."""
    gyro = ARW * np.sqrt(RATE) * np.random.default_rng(seed).standard_normal((len(TIME), 3))
    gyro[:, 1] += of_y
    np.savetxt(folder / "log.csv", gyro, "%.9g", ",", header="gx,gy,gz", comments="")
    options = ["--rate", str(RATE), "--unit-gyro", "deg/s", "--as", "soak", "--campaign", str(folder / "c")]
    assert cli.run(["diagnose", str(folder / "log.csv"), *options]) == 0
    return diagnose([read_campaign(folder / "c").campaign])


@pytest.mark.parametrize("at_s", [210.0])
def test_a_jump_is_found_where_and_as_large_as_it_was(tmp_path: Path, at_s: float) -> None:
    (finding,) = diagnosed(tmp_path, np.where(at_s < TIME, STEP, 0.0)).findings
    assert finding.effect == "gyroscope.jump"
    assert finding.value[1] == pytest.approx(3600 * STEP, abs=3.5 * finding.std[1])
    assert finding.where["in"] == "log.csv"
    assert finding.where["after_s"] == pytest.approx(at_s, abs=15)


@pytest.mark.parametrize(
    ("effect", "of"),
    [
        ("gyroscope.bias_drift", lambda t: STEP * t / SECONDS),
        ("gyroscope.bias_settling", lambda t: 1.3 * STEP * np.exp(-t / 200)),
    ],
)
def test_a_drift_and_a_settling_are_named(
    tmp_path: Path, effect: str, of: Callable[[FloatArray], FloatArray]
) -> None:
    """No thermometer was read: a drift may be a temperature as well."""
    found = diagnosed(tmp_path, of(TIME))
    assert found.findings[0].effect == effect
    assert found.findings[0].confidence == "ambiguous"
    assert "gyroscope.bias_temperature" in found.findings[0].aliases


@pytest.mark.parametrize("seed", [0])
def test_a_walk_is_never_sure_to_be_anything_else(tmp_path: Path, seed: int) -> None:
    steps = np.random.default_rng(50 + seed).standard_normal(len(TIME))
    found = diagnosed(tmp_path, np.cumsum(steps) * STEP / np.sqrt(len(TIME)), seed)
    for each in found.findings:
        assert each.confidence == "ambiguous"
        assert "gyroscope.bias_walk" in (each.effect, *each.aliases)


def test_a_tilt_is_not_sure_to_be_a_jump_of_the_accelerometers(tmp_path: Path) -> None:
    """What changes across gravity alone may be the stand; what changes along it is the sensor."""
    noise = 1e-4 * np.sqrt(RATE) * np.random.default_rng(4).standard_normal((len(TIME), 3)) + [0.02, 0.01, 1.0]
    for axis, names in ((0, {"accelerometer.jump", "placement.tilt"}), (2, {"accelerometer.jump"})):
        table = noise.copy()
        table[TIME > 450, axis] += 1e-3
        np.savetxt(tmp_path / "log.csv", table, "%.9g", ",", header="ax,ay,az", comments="")
        folder = tmp_path / f"c{axis}"
        options = ["--rate", str(RATE), "--unit-accel", "g", "--as", "soak", "--campaign", str(folder)]
        assert cli.run(["diagnose", str(tmp_path / "log.csv"), *options]) == 0
        (finding,) = diagnose([read_campaign(folder).campaign]).findings
        assert {finding.effect, *finding.aliases} == names
        assert (finding.confidence == "established") == (len(names) == 1)


def test_noise_has_none_of_them(tmp_path: Path) -> None:
    assert not diagnosed(tmp_path, 0 * TIME).findings
