"""The unit of time of generated logs: never silently wrong, seldom asked, the right one always offered."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from procedures.counts.time_unit import TimeUnit
from procedures.errors import ErrorCode
from station.applying.log_source import LogSource
from station.errors import DataRefused, TimeUnitAsked, exit_code
from station.files.campaign_folder.campaign_schema import CampaignImuTable
from station.files.campaign_folder.sample_series import step_data
from station.files.logs.log_columns import ColumnOptions, choose_columns
from station.files.logs.time_units import unit_of_time
from station.files.tables.reader import read_table
from station.files.tables.table import Table
from tests.refusals import refused
from tests.station.files.logs.generated_times import SECONDS, Stamps, generated, sensors

MAX_ASKED = 0.15
KINDS = ("soak", "rests", "motion")


def outcome(decision: Callable[[], TimeUnit]) -> TimeUnit | TimeUnitAsked:
    try:
        return decision()
    except TimeUnitAsked as asked:
        return asked


def decided(log: Stamps) -> str:
    """Return whether the decision is right, asked with the right one among those offered, or wrong."""
    moments = frozenset({log.name}) if log.unit == "iso8601" else frozenset[str]()
    table = Table(Path("log.csv"), {log.name: log.stamps}, "", moments=moments, time_scale_s=log.scale_s)
    unit = outcome(lambda: unit_of_time(table, log.name, None, None, []))
    if isinstance(unit, TimeUnitAsked):
        is_offered = any(abs(rate / log.rate_hz - 1) < 0.1 for _, rate, _ in unit.candidates)
        return "asked" if is_offered else "asked without the right one"
    step = np.diff(unit.linear(log.stamps) * unit.seconds)
    duration = float(np.sum(step) + 86400.0 * np.sum(step < -43200.0))  # a clock begins again at midnight
    is_right = abs(duration / np.ptp(log.t) - 1) < 1e-2
    return "right" if is_right else "wrong"


@pytest.mark.parametrize(("seed", "number"), [(1, 400), pytest.param(2, 4000, marks=pytest.mark.proof)])
def test_no_unit_is_silently_wrong_and_few_are_asked_for(seed: int, number: int) -> None:
    rng = np.random.default_rng(seed)
    logs = [generated(rng) for _ in range(number)]
    found = [decided(log) for log in logs]
    assert [log for log, each in zip(logs, found, strict=True) if each not in {"asked", "right"}] == []
    assert found.count("asked") <= MAX_ASKED * number
    with_header = [each for log, each in zip(logs, found, strict=True) if log.has_header]
    assert with_header.count("asked") <= 0.02 * len(with_header)


def written(file: Path, log: Stamps, kind: str, rng: np.random.Generator) -> Path:
    columns = sensors(kind, log.t, rng)
    stamps = [f"{each:.{log.decimals}f}" for each in log.stamps]
    if log.unit == "iso8601":
        moments = (log.stamps * 1e6).round().astype("datetime64[us]")
        stamps = [str(each) + "Z" for each in moments]
    rows = zip(stamps, *(values.tolist() for values in columns.values()), strict=True)
    lines = [
        ",".join([log.name, *columns]),
        *(f"{row[0]}," + ",".join(f"{v:.5f}" for v in row[1:]) for row in rows),
    ]
    file.write_text("\n".join(lines) + "\n")
    return file


def test_a_file_is_read_as_its_columns_are_and_streamed_as_it_is_read(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    asked = 0
    for i in range(12):
        log = generated(rng)
        if log.scale_s is not None:
            continue
        file = written(tmp_path / f"{i}.csv", log, KINDS[i % 3], rng)
        whole = outcome(lambda file=file: choose_columns(read_table(file), ColumnOptions()).unit_time)
        streamed = outcome(lambda file=file: LogSource.open(file, ColumnOptions()).found.unit_time)
        if isinstance(whole, TimeUnitAsked):
            asked += 1
            assert isinstance(streamed, TimeUnitAsked)
            assert (exit_code(whole), whole.code) == (2, ErrorCode.TIME_UNIT)
            assert [unit for unit, *_ in streamed.candidates] == [unit for unit, *_ in whole.candidates]
            stated = whole.candidates[0][0]
            assert choose_columns(read_table(file), ColumnOptions(unit_time=stated)).unit_time.name == stated
        else:
            assert whole == streamed
            assert whole.seconds == SECONDS[log.unit], (log, whole)
    assert asked < 6


def test_rows_without_outputs_are_none_of_the_sample_rate(tmp_path: Path) -> None:
    rows = [f"{i / 100:.3f},{i % 7 / 10},{i % 5 / 10}," for i in range(5000)]
    others = [f"{i / 100 + 0.003:.3f},,,{i}" for i in range(5000)]  # of another device, between them
    file = tmp_path / "log.csv"
    file.write_text(
        "time,gx,gy,gps\n" + "\n".join(each for pair in zip(rows, others, strict=True) for each in pair)
    )
    whole = choose_columns(read_table(file), ColumnOptions())
    for found in (whole, LogSource.open(file, ColumnOptions()).found):
        assert any(": 100 Hz" in guess for guess in found.guesses)


def test_a_table_in_memory_that_is_streamed_shows_the_duration_of_the_whole(tmp_path: Path) -> None:
    t = np.arange(100_000.0)
    file = tmp_path / "log.npz"
    np.savez(file, time=t, gx=np.sin(t))
    with pytest.raises(TimeUnitAsked) as asked:
        LogSource.open(file, ColumnOptions())
    assert ("ms", pytest.approx(1000.0), pytest.approx(99.999)) in asked.value.candidates


@pytest.mark.parametrize(("stated", "hz"), [("s", 1.0), ("tick:1e-4", 1e4), ("unix-ms", 1e3), ("epoch_ms", 1e3)])
def test_a_unit_that_is_specified_wins(stated: str, hz: float) -> None:
    table = Table(Path("log.csv"), {"time": np.arange(1000.0)}, "")
    assert 1 / unit_of_time(table, "time", stated, None, []).seconds == pytest.approx(hz)


@pytest.mark.parametrize("stated", ["days", "ns"])
def test_a_unit_that_is_specified_and_makes_no_possible_rate_is_refused(stated: str) -> None:
    table = Table(Path("log.csv"), {"time": np.arange(1000.0)}, "")
    with refused(DataRefused, ErrorCode.TIME_UNIT):
        unit_of_time(table, "time", stated, None, [])


@pytest.mark.parametrize(
    ("clock", "per_second"),
    [("timestamp_us", 1e6), ("unix_ms", 1e3), ("utc", 1.0)],
)
def test_a_second_clock_decides_what_the_steps_leave_open(clock: str, per_second: float) -> None:
    n = np.arange(3000.0)
    other = (1.7e9 + n / 1000) * per_second
    table = Table(Path("log.csv"), {"time": n, clock: other}, "")
    assert unit_of_time(table, "time", None, None, []).name == "ms"
    table = Table(Path("log.csv"), {"time": n, clock: (1.7e9 + n) * per_second}, "")
    assert unit_of_time(table, "time", None, None, []).name == "s"


@pytest.mark.parametrize("factor", [1e3, 1e6, 1e9, 1e4, 1 / 60])
def test_a_campaign_whose_t_s_is_in_another_unit_is_refused(factor: float) -> None:
    imu = CampaignImuTable(model="m", serial="s", sample_period_s=0.01, output="rate")
    t, gyro = 0.01 * np.arange(1.0, 500.0) * factor, np.random.default_rng(1).standard_normal((3, 499))
    columns = {"t_s": t, **{f"g{a}": gyro[i] for i, a in enumerate("xyz")}}
    with refused(DataRefused, ErrorCode.TIME_UNIT):
        step_data(Table(Path("soak.csv"), columns), imu)
