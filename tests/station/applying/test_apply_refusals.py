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
from tests.station.applying.run import apply, nothing_written, refusal, written
from tests.station.calibrated.test_calibration_applied import effect

WITHOUT_T = {name: column for name, column in COLUMNS.items() if name != "temp_c"}
BACK = dict(COLUMNS, t_s=np.concatenate((T_S[:3000], T_S[3000:] - 20)))
FRACTIONS = dict(COLUMNS, gy=COUNTS[:, 1] + 0.25)
BY_UNIT = {name if name not in NAMES[:3] else f"{name} [deg/s]": column for name, column in COLUMNS.items()}
LAGS = effect("gyroscope.temperature_lag", x=3.0, y=-2.0, z=1.0, tau_s=30.0)
NO_ACCEL = {name: column for name, column in COLUMNS.items() if name not in NAMES[3:]}
SENSITIVE = effect("gyroscope.g_sensitivity", xz=0.7, yy=-0.3)
ONE = {name: column[:3] for name, column in COLUMNS.items()} | {"t_s": np.array([5.0, np.nan, np.nan])}
CLASH = COLUMNS | {"aux_a-b": VOLTS, "aux_a b": VOLTS}
HUGE = effect("accelerometer.quadratic", x=-0.9, y=2.0, z=2.0)


@pytest.mark.parametrize(
    ("columns", "effects", "options", "reported"),
    [
        (COLUMNS, (), ("--serial", "S2"), "S2"),
        (WITHOUT_T, (LAGS,), (), "gyroscope.temperature_lag (up to 75 deg/h)"),
        (NO_ACCEL, (SENSITIVE,), (), "gyroscope.g_sensitivity (up to 0.7 deg/h)"), (BACK, (), (), "a.csv:3002:"),
        (FRACTIONS, (), (), "a.csv:2:"), (BY_UNIT, (), (), "deg/s"),
        (COLUMNS, (), ("--time", "t_s", "--rate", "51"), "+2.0%"),
        (COLUMNS, (), ("--rate", "51"), "--rate 51"), (COLUMNS, (HUGE,), (), "accelerometer.quadratic"),
        (COLUMNS, (), ("--gyro", "wx,wy,wz"), "'wx'"),
        (COLUMNS, (), ("--without", "gyroscope.moonlight"), "gyroscope.moonlight"),
        (ONE, (), (), "a.csv"), (CLASH, (), (), "aux_a_b"),
    ],
)  # fmt: skip
def test_bad_input_is_refused_and_nothing_is_written(
    tmp_path: Path, columns: dict[str, np.ndarray], effects: tuple[dict[str, object], ...],
    options: tuple[str, ...], reported: str,
) -> None:  # fmt: skip
    known, source = calibration_file(tmp_path, *effects), write_csv(tmp_path / "a.csv", columns)
    with nothing_written(tmp_path):
        result = apply(source, "--calibration", known, "--out", tmp_path / "o.csv", *options)
    assert reported in str(refusal(result))


def test_a_calibration_of_rates_refuses_counts(tmp_path: Path) -> None:
    known = calibration_file(tmp_path, unit="output")
    for source in (write_campaign(tmp_path / "c"), write_npz(tmp_path / "a.npz")):
        refusal(apply(source, "--calibration", known, "--out", tmp_path / "o.npz"))
    rates = {name: column / PERIOD if name in NAMES else column for name, column in COLUMNS.items()}
    result = apply(write_npz(tmp_path / "r.npz", rates), "--calibration", known, "--out", tmp_path / "o.npz")
    assert result.exit_code == 0, repr(result.exception)
    plain = np.hstack(evaluated(document(), COUNTS / PERIOD, T_S, TEMP))
    assert written(tmp_path / "o.npz") == pytest.approx(plain, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize(
    ("names", "options", "reported"),
    [("{} [rad/s]", (), "0.01745"), ("{}_deg_s", (), "3.593e+05"), ("{}", ("--unit-gyro", "deg/h"), "3600")],
)
def test_rates_in_another_unit_than_the_calibrations_are_refused(
    tmp_path: Path, names: str, options: tuple[str, ...], reported: str
) -> None:
    known = calibration_file(tmp_path, unit="output")
    columns = {names.format(n) if n in NAMES[:3] else n: c for n, c in COLUMNS.items()}
    stated = ("--gyro", ",".join(map(names.format, NAMES[:3])), *options)
    result = apply(
        write_csv(tmp_path / "a.csv", columns), "--calibration", known, "--out", tmp_path / "o.npz", *stated
    )
    assert reported in str(refusal(result))


@pytest.mark.parametrize(
    "more",
    [{"effects": None}, {"temperature_range_c": "warm"}, {"valid_until": "2027-01-01"}, {"accepted_utc": 7}],
)
def test_a_calibration_with_something_else_in_it_is_refused(tmp_path: Path, more: dict[str, object]) -> None:
    known, source = calibration_file(tmp_path, **more), write_npz(tmp_path / "a.npz")
    found = refusal(apply(source, "--calibration", known, "--out", tmp_path / "o.npz"))
    assert next(iter(more)) in str(found)


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
    assert "49.2611 Hz" in str(refusal(apply(slow, "--calibration", known, "--out", tmp_path / "o.npz")))
    other = write_campaign(tmp_path / "other", serial="S9")
    assert "S9" in str(refusal(apply(other, "--calibration", known, "--out", tmp_path / "o.npz")))


def test_the_line_that_is_named_counts_lines_that_hold_no_row(tmp_path: Path) -> None:
    source = write_csv(tmp_path / "a.csv", BACK)
    lines = source.read_text().splitlines(keepends=True)
    source.write_text("".join([*lines[:100], "\n", "\n", *lines[100:]]))
    asked = ("--calibration", calibration_file(tmp_path), "--out", tmp_path / "o.npz")
    assert refusal(apply(source, *asked)).line == 3004
