"""Told units against gravity and the rest: samples of a known truth, written in another unit than was told."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.logs.log_campaign import LogOptions, campaign_of_logs
from station.files.logs.log_columns import ColumnOptions
from tests.refusals import refused

G, HZ = 9.80665, 50.0
UP = np.array([0.1, -0.2, np.sqrt(0.95)])


def truth(seconds: float = 20.0, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Specific force [g] with a bias of 3 %, and rate [deg/s] with a bias of some deg/s, at rest."""
    draw, n = np.random.default_rng(seed), round(seconds * HZ)
    f = UP + np.array([0.02, -0.01, 0.02]) + draw.normal(0, 2e-3, (n, 3))
    return f, np.array([1.5, -2.0, 0.5]) + draw.normal(0, 0.05, (n, 3))


def read(
    folder: Path, f: np.ndarray, w: np.ndarray, names: str = "t gx gy gz ax ay az", **stated: Any
) -> list[str]:
    """Return what is said of a log of these numbers."""
    file, t = folder / "log.csv", np.arange(len(f)) / HZ
    rows = np.column_stack((t, w, f))
    np.savetxt(file, rows, fmt="%.9g", delimiter=",", header=",".join(names.split()), comments="")
    return list(campaign_of_logs([file], LogOptions(ColumnOptions(unit_time="s", **stated))).notes)


RIGHT = [
    ("m/s2", G), ("g", 1.0), ("mg", 1e3), ("ug", 1e6), ("cm/s2", 100 * G), ("16384/g", 16384.0), ("raw", 77.0),
    ("-16384/g"[1:], 16384.0), ("100/(m/s2)", 100 * G),
]  # fmt: skip


@pytest.mark.parametrize(("unit", "per_g"), RIGHT)
def test_units_that_are_right_are_not_spoken_of(tmp_path: Path, unit: str, per_g: float) -> None:
    f, w = truth()
    assert read(tmp_path, f * per_g, w, unit_accel=unit, unit_gyro="deg/s") == []


WRONG = [  # what was specified, outputs in 1 g in truth, what the remedy must hold
    ("m/s2", 1.0, "--unit-accel g"), ("g", G, "--unit-accel m/s2"), ("mg", 1.0, "--unit-accel g"),
    ("g", 1e3, "--unit-accel mg"), ("m/s2", 1e3, "--unit-accel mg"), ("m/s2", 100 * G, "--unit-accel cm/s2"),
    ("ug", 1e3, "--unit-accel mg"), ("m/s2", 16384.0, "--unit-accel 16384/g"), ("g", 2048.0, "2048/g"),
    ("16384/g", 8192.0, "--unit-accel 8192/g"), ("16384/g", 4096.0, "4096/g"), ("16384/g", 2048.0, "2048/g"),
    ("2048/g", 16384.0, "16384/g"), ("16384/g", G, "--unit-accel m/s2"), ("m/s2", G / HZ, "in 0.02 s"),
    ("g", 1 / HZ, "in 0.02 s"), ("m/s2", G * 0.005, "in 0.005 s"), ("m/s2", G * 0.01, "in 0.01 s"),
]  # fmt: skip


@pytest.mark.parametrize(("stated", "per_g", "remedy"), WRONG)
def test_a_unit_that_gravity_contradicts_is_refused_with_what_the_data_are(
    tmp_path: Path, stated: str, per_g: float, remedy: str
) -> None:
    f, w = truth()
    with refused(DataRefused, ErrorCode.UNIT) as found:
        read(tmp_path, f * per_g, w, unit_accel=stated)
    assert remedy in str(found.value)
    read(tmp_path, f * per_g, w, unit_accel="raw")


@pytest.mark.parametrize(("accel", "gyro", "per_g", "per_deg_s"), [
    ("m/s2", "rad/s", G, np.pi / 180), ("g", "deg/s", 1.0, 1.0), ("mg", "deg/h", 1e3, 3600.0),
])  # fmt: skip
def test_increments_are_repaired_in_both_triads_by_the_interval_alone(
    tmp_path: Path, accel: str, gyro: str, per_g: float, per_deg_s: float
) -> None:
    f, w = truth()
    f, w = f * per_g / HZ, w * per_deg_s / HZ
    options = f"--unit-accel {per_g / HZ:.6g}/g --unit-gyro '{per_deg_s / HZ:.6g}/(deg/s)'"
    with refused(DataRefused, ErrorCode.UNIT, options):
        read(tmp_path, f, w, unit_accel=accel, unit_gyro=gyro)
    stated = {"unit_accel": f"{per_g / HZ:.6g}/g", "unit_gyro": f"{per_deg_s / HZ:.6g}/(deg/s)"}
    assert read(tmp_path, f, w, **stated) == []


def test_a_rest_in_the_middle_of_a_motion_is_enough(tmp_path: Path) -> None:
    f, w = truth()
    f[:400] += np.random.default_rng(3).normal(0, 1, (400, 3)).cumsum(axis=0) / 10
    f[600:] += np.random.default_rng(4).normal(0, 1, (400, 3)).cumsum(axis=0) / 10
    assert read(tmp_path, f, w, unit_accel="g") == []
    with pytest.raises(DataRefused):
        read(tmp_path, f, w, unit_accel="m/s2")


def test_one_axis_alone_may_show_any_part_of_gravity(tmp_path: Path) -> None:
    f, w = truth()
    assert read(tmp_path, f, w, accel=("-", "-", "az"), unit_accel="m/s2") == []
    with pytest.raises(DataRefused):
        read(tmp_path, f * 1000, w, accel=("-", "-", "az"), unit_accel="g")


@pytest.mark.parametrize(("stated", "per_deg_s", "remedy"), [
    ("deg/s", 131.0, "--unit-gyro 131/(deg/s)"), ("deg/s", 1e3, "--unit-gyro mdeg/s"),
    ("rad/s", 1.0, "--unit-gyro deg/s"), ("deg/s", 3600.0, "--unit-gyro deg/h"),
])  # fmt: skip
def test_a_rate_at_rest_that_no_bias_explains_is_refused(
    tmp_path: Path, stated: str, per_deg_s: float, remedy: str
) -> None:
    f, w = truth()
    with refused(DataRefused, ErrorCode.UNIT) as found:
        read(tmp_path, f, w * per_deg_s, unit_accel="g", unit_gyro=stated)
    assert remedy.split()[0] in str(found.value)
    read(tmp_path, f, w * per_deg_s, unit_accel="g", unit_gyro="raw")


def test_twos_complement_that_was_not_applied_is_refused_and_raw_goes_on(tmp_path: Path) -> None:
    f, w = truth()
    f[:, 1] -= f[:, 1].mean() + 0.03
    numbers = np.rint(np.hstack(((w - w.mean(axis=0)) * 131, f * 16384))) % 65536
    stated = {"unit_gyro": "131/(deg/s)", "unit_accel": "16384/g"}
    for units in (stated, {}):
        with refused(DataRefused, ErrorCode.UNIT) as found:
            read(tmp_path, numbers[:, 3:], numbers[:, :3], **units)
        assert "gx, gy, gz" in str(found.value)
    reported = read(tmp_path, numbers[:, 3:], numbers[:, :3], unit_gyro="raw", unit_accel="raw")
    assert reported
    with refused(DataRefused):  # one level above the middle: gravity determines it
        read(tmp_path, numbers[:, 3:], w, unit_accel="16384/g")


@pytest.mark.parametrize("scale", [G, 16384.0])
def test_letters_of_gyroscopes_with_the_length_of_gravity_are_asked_about(tmp_path: Path, scale: float) -> None:
    f, w = truth()
    with refused(DataRefused, ErrorCode.COLUMNS):
        read(tmp_path, w, f * scale, "t gx gy gz n1 n2 n3")
    read(tmp_path, w, f * scale, "t gx gy gz n1 n2 n3", gyro=("gx", "gy", "gz"))
    read(tmp_path, w, f * scale, "t gx gy gz n1 n2 n3", accel=("gx", "gy", "gz"))


@pytest.mark.parametrize("per_g", [1024.0, 890.0])
def test_a_length_that_several_units_explain_decides_none(tmp_path: Path, per_g: float) -> None:
    f, w = truth()
    file, t = tmp_path / "log.csv", np.arange(len(f)) / HZ
    rows = np.column_stack((t, w, f * per_g))
    np.savetxt(file, rows, fmt="%.6g", delimiter=",", header="t,gx,gy,gz,ax,ay,az", comments="")
    found = campaign_of_logs([file], LogOptions(ColumnOptions(unit_time="s")))
    assert found.loaded.tables.imu.unit_accel is None
    assert any("--unit-accel" in each for each in found.guesses)


def test_planted_kinds_and_units_are_never_silently_wrong(tmp_path: Path) -> None:
    """60 logs of planted sensors: right units are read without a word, wrong ones are refused or said."""
    draw, silent, falsely = np.random.default_rng(20), [], []
    accel_units = {"m/s2": G, "g": 1.0, "mg": 1e3, "16384/g": 16384.0, "4096/g": 4096.0}
    gyro_units = {"deg/s": 1.0, "rad/s": np.pi / 180, "mdeg/s": 1e3, "131/(deg/s)": 131.0}
    for i in range(60):
        f, w = truth(8.0, seed=i)
        if moves := i % 3:
            n, t = len(f), np.arange(len(f)) / HZ
            shaken = np.sin(2 * np.pi * draw.uniform(0.5, 3) * t)[:, None] * draw.uniform(-0.5, 0.5, 3)
            still = slice(0, 100) if moves == 1 else slice(n - 90, n)
            shaken[still] = 0
            f, w = f + shaken, w + 60 * shaken
        truly, stated = (str(draw.choice(list(accel_units))) for _ in range(2))
        rates = str(draw.choice(list(gyro_units)))
        stated = truly if i % 2 else stated
        f, w = f * accel_units[truly], w * gyro_units[rates]
        try:
            reported = read(tmp_path, f, w, unit_accel=stated, unit_gyro=rates)
        except DataRefused as error:
            is_named = error.code == ErrorCode.UNIT and truly in str(error)
            if truly == stated or not is_named:
                falsely.append((truly, stated, str(error)))
        else:
            (silent if truly != stated and not reported else []).append((truly, stated))
    assert silent == []
    assert falsely == []
