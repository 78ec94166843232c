"""What `station apply` refuses: in one line, with exit code 3, and nothing is written."""

from pathlib import Path

import numpy as np
import pytest

from tests.station.applying.independent import evaluated
from tests.station.applying.inputs import (
    COLUMNS,
    COUNTS,
    NAMES,
    PERIOD,
    T_S,
    TEMP,
    VOLTS,
    calibration_file,
    document,
    write_campaign,
    write_csv,
    write_npz,
)  # fmt: skip
from tests.station.applying.run import apply, refused, written
from tests.station.calibrated.test_calibration_applied import effect

WITHOUT_T = {name: column for name, column in COLUMNS.items() if name != "temp_c"}
BACK = dict(COLUMNS, t_s=np.concatenate((T_S[:3000], T_S[3000:] - 20)))
FRACTIONS = dict(COLUMNS, gy=COUNTS[:, 1] + 0.25)
PER_SECOND = COLUMNS | {name: np.rint(column / PERIOD) for name, column in COLUMNS.items() if name in NAMES}
BY_UNIT = {name if name not in NAMES[:3] else f"{name} [deg/s]": column for name, column in COLUMNS.items()}
LAGS = effect("gyroscope.temperature_lag", x=3.0, y=-2.0, z=1.0, tau_s=30.0)
NO_ACCEL = {name: column for name, column in COLUMNS.items() if name not in NAMES[3:]}
SENSITIVE = effect("gyroscope.g_sensitivity", xz=0.7, yy=-0.3)
HUGE = effect("accelerometer.quadratic", x=-0.9, y=2.0, z=2.0)


@pytest.mark.parametrize(
    ("columns", "effects", "options", "said"),
    [
        (COLUMNS, (), ("--serial", "S2"), "found serial S2, expected S1, which the calibration is of"),
        (WITHOUT_T, (LAGS,), (), r"gyroscope.temperature_lag (up to 75 deg/h)"),
        (NO_ACCEL, (SENSITIVE,), (), r"gyroscope.g_sensitivity (up to 0.7 deg/h)"),
        (BACK, (), (), ":3002: found time 45.02 after 65, expected times that rise"),
        (FRACTIONS, (), (), ":2: found "),
        (BY_UNIT, (), (), "found rates in deg/s, expected counts, which the calibration is of"),
        (COLUMNS, (), ("--time", "t_s", "--rate", "51"), "50 Hz by the times, +2.0% of the period"),
        (COLUMNS, (), ("--rate", "51"), "50 rows a second by column t_s, expected --rate 51 within 1 %"),
        (COLUMNS, (HUGE,), (), "accelerometer.quadratic not to settle in "),
        (COLUMNS, (), ("--gyro", "wx,wy,wz"), "no column 'wx'"),
        (COLUMNS, (), ("--without", "gyroscope.moonlight"), "no effect gyroscope.moonlight"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line_and_nothing_is_written(
    tmp_path: Path, columns: dict[str, np.ndarray], effects: tuple[dict[str, object], ...],
    options: tuple[str, ...], said: str,
) -> None:  # fmt: skip
    known, source = calibration_file(tmp_path, *effects), write_csv(tmp_path / "a.csv", columns)
    line = refused(apply(source, "--calibration", known, "--out", tmp_path / "o.csv", *options))
    assert said in line
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "calibration.json"]


def test_a_calibration_of_rates_refuses_counts(tmp_path: Path) -> None:
    known = calibration_file(tmp_path, unit="output")
    line = refused(apply(write_campaign(tmp_path / "c"), "--calibration", known, "--out", tmp_path / "o.npz"))
    assert "found counts (increments), expected rates, which the calibration is of" in line
    line = refused(apply(write_npz(tmp_path / "a.npz"), "--calibration", known, "--out", tmp_path / "o.npz"))
    assert "increments of each sample, not rates" in line
    rates = {name: column / PERIOD if name in NAMES else column for name, column in COLUMNS.items()}
    result = apply(write_npz(tmp_path / "r.npz", rates), "--calibration", known, "--out", tmp_path / "o.npz")
    assert result.exit_code == 0, repr(result.exception)
    plain = np.hstack(evaluated(document(), COUNTS / PERIOD, T_S, TEMP))
    assert written(tmp_path / "o.npz") == pytest.approx(plain, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("names", "options", "said"),
    [
        ("{} [rad/s]", (), "gyroscope in rad/s, 0.01745 outputs in 1 deg/s, expected 3.593e+05 outputs"),
        ("{}_deg_s", (), "gyroscope in deg/s, 1 outputs in 1 deg/s"),
        ("{}", ("--unit-gyro", "deg/h"), "gyroscope in deg/h, 3600 outputs in 1 deg/s"),
    ],
)
def test_rates_in_another_unit_than_the_calibrations_are_refused(
    tmp_path: Path, names: str, options: tuple[str, ...], said: str
) -> None:
    known = calibration_file(tmp_path, unit="output")
    columns = {names.format(n) if n in NAMES[:3] else n: c for n, c in COLUMNS.items()}
    told = ("--gyro", ",".join(map(names.format, NAMES[:3])), *options)
    asked = ("--calibration", known, "--out", tmp_path / "o.npz", *told)
    assert said in refused(apply(write_csv(tmp_path / "a.csv", columns), *asked))


def test_an_archive_that_is_damaged_further_on_is_refused(tmp_path: Path) -> None:
    known, source = calibration_file(tmp_path), write_npz(tmp_path / "a.npz")
    content = bytearray(source.read_bytes())
    content[len(content) // 2] ^= 0xFF
    source.write_bytes(content)
    line = refused(apply(source, "--calibration", known, "--out", tmp_path / "o.npz"))
    assert "a.npz" in line
    assert not (tmp_path / "o.npz").exists()


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"effects": None}, "expected a list of effects"),
        ({"temperature_range_c": "warm"}, "temperature_range_c 'warm', expected two numbers"),
        ({"valid_until": "2027-01-01"}, "valid_until '2027-01-01', expected a time with its zone"),
        ({"accepted_utc": 7}, "accepted_utc 7, expected a time with its zone"),
    ],
)
def test_a_calibration_with_something_else_in_it_is_refused(
    tmp_path: Path, more: dict[str, object], said: str
) -> None:
    known, source = calibration_file(tmp_path, **more), write_npz(tmp_path / "a.npz")
    assert said in refused(apply(source, "--calibration", known, "--out", tmp_path / "o.npz"))


def test_what_is_read_is_never_written_over(tmp_path: Path) -> None:
    folder, known = write_campaign(tmp_path / "c"), calibration_file(tmp_path)
    step = next(path for path in folder.iterdir() if path.suffix in {".csv", ".mcap"})
    before = {path: path.read_bytes() for path in (*folder.iterdir(), known)}
    for out in (step, folder / f"{step.stem}.csv"):
        result = apply(folder, "--calibration", known, "--out", out)
        assert result.exception is not None or out not in before
        assert out not in before or "would be lost" in str(result.exception)
    assert all(path.read_bytes() == content for path, content in before.items())


def test_a_campaign_of_another_period_or_unit_is_refused(tmp_path: Path) -> None:
    known = calibration_file(tmp_path)
    slow = write_campaign(tmp_path / "slow", period=0.0203)
    line = refused(apply(slow, "--calibration", known, "--out", tmp_path / "o.npz"))
    assert "expected 49.2611 Hz as is stated, within 1 %" in line
    other = write_campaign(tmp_path / "other", serial="S9")
    assert "found serial S9" in refused(apply(other, "--calibration", known, "--out", tmp_path / "o.npz"))


def test_a_mat_above_2_gb_and_an_unknown_suffix_are_refused(tmp_path: Path) -> None:
    from station.errors import DataRefused
    from station.files.sample_files import WRITERS
    from station.files.sample_files.sample_file import SampleColumns

    with pytest.raises(DataRefused, match=r"2\.4 GB of samples, expected at most 2 GB"):
        WRITERS[".mat"](tmp_path / "o.mat", SampleColumns(("a",) * 8, 37_500_000, "sensor", True))
    known, source = calibration_file(tmp_path), write_npz(tmp_path / "a.npz")
    assert "found suffix '.xls', expected one of" in refused(
        apply(source, "--calibration", known, "--out", tmp_path / "o.xls")
    )
    assert list(tmp_path.glob("o.*")) == []


ONE = {name: column[:3] for name, column in COLUMNS.items()} | {"t_s": np.array([5.0, np.nan, np.nan])}
CLASH = COLUMNS | {"aux_a-b": VOLTS, "aux_a b": VOLTS}


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        (ONE, "found a single sample with a time, expected two at least"),
        (CLASH, "found channels 'aux_a-b' and 'aux_a b', which both would be column aux_a_b, expected a name"),
    ],
)
def test_a_log_of_one_row_and_channels_of_one_name_are_refused(
    tmp_path: Path, columns: dict[str, np.ndarray], said: str
) -> None:
    known, source = calibration_file(tmp_path), write_csv(tmp_path / "a.csv", columns)
    assert said in refused(apply(source, "--calibration", known, "--out", tmp_path / "o.npz"))


def test_the_line_that_is_named_counts_lines_that_hold_no_row(tmp_path: Path) -> None:
    source = write_csv(tmp_path / "a.csv", BACK)
    lines = source.read_text().splitlines(keepends=True)
    source.write_text("".join([*lines[:100], "\n", "\n", *lines[100:]]))
    asked = ("--calibration", calibration_file(tmp_path), "--out", tmp_path / "o.npz")
    assert ":3004: found time 45.02 after 65" in refused(apply(source, *asked))
