"""The exported MATLAB, run by a reader of its own against the library, and by GNU Octave where there is one."""

import json
import shutil
import subprocess
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from station import cli
from tests.station.calibrated.test_calibration_applied import calibration
from tests.station.exports.c_and_station import DT, by_library, random_samples
from tests.station.exports.every_effect import every_effect, with_facts
from tests.station.exports.matlab_read import functions_of, mat, numbers_of


def exported(folder: Path, document: dict[str, Any], name: str = "fog_imu") -> Path:
    (folder / "c.json").write_text(json.dumps(document))
    out = folder / f"{name}.m"
    assert cli.run(["export", str(folder / "c.json"), "--to", "matlab", "--out", str(out)]) == 0
    return out


def test_with_every_effect_it_is_what_the_library_makes_of_the_counts(tmp_path: Path) -> None:
    document, samples = every_effect(), random_samples(250, 4, 0.5)
    out = exported(tmp_path, document, "nav_imu")
    numbers, apply = numbers_of(out.with_suffix(".mat")), functions_of(out.read_text())["nav_imu"]
    state: Any = SimpleNamespace(magnetic_ut=mat(np.zeros((3, 1))))
    found = np.empty((250, 6))
    for i in range(250):
        state.magnetic_ut = mat(samples.field[i]).T
        force, rate, state = apply(numbers, state, mat(samples.counts[i]), samples.T[i], 0.5)
        found[i] = np.concatenate((force.ravel(), rate.ravel()))
    expected = np.hstack(by_library(document, samples))
    for part in (slice(0, 3), slice(3, 6)):
        size = np.linalg.norm(expected[:, part], axis=1)
        assert (np.linalg.norm(found[:, part] - expected[:, part], axis=1) / size).max() < 1e-12


def test_without_effects_and_with_one_triad(tmp_path: Path) -> None:
    document = with_facts(calibration())
    del document["gyroscope"]
    out = exported(tmp_path, document)
    numbers, apply = numbers_of(out.with_suffix(".mat")), functions_of(out.read_text())["fog_imu"]
    samples = random_samples(5, 1)
    force, rate, _ = apply(numbers, mat(np.zeros((0, 0))), mat(samples.counts[0]), np.nan, DT)
    assert force.ravel() == pytest.approx(by_library(document, samples)[0][0], rel=1e-13)
    assert np.isnan(rate).all()


@pytest.mark.skipif(shutil.which("octave") is None, reason="no GNU Octave")
def test_octave_gets_its_own_samples(tmp_path: Path) -> None:
    exported(tmp_path, every_effect())
    code = (
        "c = load('fog_imu.mat'); s = c.samples; worst = 0; for i = 1:12, if mod(i, 6) == 1, "
        "state = struct('magnetic_ut', [20; -5; 40]); end; "
        "[f, r, state] = fog_imu(c, state, s.counts(i, :), s.temperature(i), s.dt_s(i)); "
        "worst = max([worst, norm(f' - s.force(i, :)) / norm(f), norm(r' - s.rate(i, :)) / norm(r)]); end; "
        "printf('%.3g', worst);"
    )
    ran = subprocess.run(["octave", "--eval", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert float(ran.stdout) < 1e-12
