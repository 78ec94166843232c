"""Two clocks in one log: what contradicts the other is asked for, and what only looks so is not."""

from pathlib import Path

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.errors import ErrorCode
from station.applying.log_source import LogSource
from station.errors import ClocksContradict, exit_code
from station.files.logs.log_columns import ColumnOptions, LogColumns, choose_columns
from station.files.tables.reader import read_table
from tests.refusals import refused

N = np.arange(6000.0)
UNIX_MS = 1.79e12 + 10.0 * N


def whole(file: Path, stated: ColumnOptions) -> LogColumns:
    return choose_columns(read_table(file), stated)


def streamed(file: Path, stated: ColumnOptions) -> LogColumns:
    return LogSource.open(file, stated).found


def written(file: Path, columns: dict[str, FloatArray]) -> Path:
    gyro = np.random.default_rng(1).standard_normal((3, len(N)))
    columns = columns | {f"g{axis}": gyro[i] for i, axis in enumerate("xyz")}
    rows = np.column_stack(list(columns.values())).tolist()
    file.write_text("\n".join([",".join(columns), *(",".join(f"{v:.6f}" for v in row) for row in rows)]) + "\n")
    return file


@pytest.mark.parametrize("rate", [0.5, 0.97, 2.0])
def test_clocks_that_contradict_each_other_are_asked_for_in_both_ways_of_reading(
    tmp_path: Path, rate: float
) -> None:
    file = written(tmp_path / "log.csv", {"time_s": 0.01 * N * rate, "unix_ms": UNIX_MS})
    for read in (whole, streamed):
        with refused(ClocksContradict, ErrorCode.TIME_UNIT) as found:
            read(file, ColumnOptions())
        assert exit_code(found.value) == 2
        assert {name: hz for name, hz, _ in found.value.clocks} == pytest.approx(
            {"time_s": 100 / rate, "unix_ms": 100.0}, rel=1e-6
        )
        for stated in ("time_s", "unix_ms"):
            assert read(file, ColumnOptions(time=stated)).time == stated


def fixed_late() -> FloatArray:
    return np.where(N < 2500, 0.0, UNIX_MS)


@pytest.mark.parametrize(
    "column",
    [
        {"unix_ms": UNIX_MS * 1.0},
        {"unix_ms": 1.79e12 + (UNIX_MS - 1.79e12) * 1.003},  # a poor crystal
        {"unix_s": np.floor(UNIX_MS / 1e3)},  # whole seconds
        {"gps_time_s": np.floor(N / 20) * 0.2 + 357200.0},  # written five times a second
        {"gps_time_s": np.floor(N / 500) * 5.0 + 357200.0},  # rises too seldom
        {"unix_ms": UNIX_MS + 30_000.0 * (N > 3000)},  # set on
        {"unix_ms": UNIX_MS - 30_000.0 * (N > 3000)},  # set back
        {"unix_ms": fixed_late()},
        {"unix_ms": 1.79e12 + np.ceil(N / 16) * 160.0},  # read in bursts of a radio link
        {"unix_ms": UNIX_MS + np.random.default_rng(2).uniform(0.0, 9.0, len(N))},  # late read-outs
        {"exposure_time_us": 800.0 + np.random.default_rng(3).uniform(0.0, 9.0, len(N))},
        {"sync_time_ms": np.full(len(N), 12.0)},
    ],
)
def test_clocks_that_agree_or_cannot_be_compared_are_not_asked_for(
    tmp_path: Path, column: dict[str, FloatArray]
) -> None:
    file = written(tmp_path / "log.csv", {"time_s": 0.01 * N} | column)
    assert choose_columns(read_table(file), ColumnOptions()).time == "time_s"
    assert LogSource.open(file, ColumnOptions()).found.time == "time_s"


def test_text_in_a_clock_that_is_not_needed_is_no_refusal(tmp_path: Path) -> None:
    file = written(tmp_path / "log.csv", {"time_s": 0.01 * N, "unix_ms": UNIX_MS})
    lines = file.read_text().split("\n")
    lines[5000] = lines[5000].replace(lines[5000].split(",")[1], "no fix")
    file.write_text("\n".join(lines))
    assert choose_columns(read_table(file), ColumnOptions()).time == "time_s"
    assert LogSource.open(file, ColumnOptions()).found.time == "time_s"
