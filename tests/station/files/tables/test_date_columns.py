"""Dates and clocks as loggers, spreadsheets and MATLAB write them; what could be read in two ways is asked for."""

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.logs.log_columns import ColumnOptions, choose_columns
from station.files.logs.log_data import log_data
from station.files.tables.dates import DateOrder, moment
from station.files.tables.reader import open_table, read_table
from tests.refusals import refused

MORNING = datetime(2026, 3, 12, 9, 14, 3, tzinfo=UTC).timestamp()
WRITTEN = [
    "2026-03-12T09:14:03.000", "2026-03-12 09:14:03,000", "2026/03/12 09:14:03", "2026.03.12 9:14:03",
    "2026-03-12_09:14:03", "2026-03-12T10:14:03+01:00", "2026-03-12 09:14:03 UTC", "20260312T091403Z",
    "20260312 091403.000", "2026-03-12 09:14:03:000", "12.03.2026 09:14:03.000", "12.3.2026 9:14:03",
    "12.03.26 09:14:03,000", "12.03.2026, 09:14:03", "12-Mar-2026 09:14:03", "12 Mar 2026 09:14:03.000",
    "12.03.2026 9:14:03 AM",
]  # fmt: skip


@pytest.mark.parametrize("cell", WRITTEN)
def test_a_date_that_can_be_read_in_one_way(cell: str) -> None:
    assert moment(cell) == pytest.approx(MORNING, abs=1e-6)


@pytest.mark.parametrize(
    ("cell", "seconds"),
    [("12:00:00 AM", 0.0), ("12:30:00 PM", 45000.0), ("1:00:00.5 PM", 46800.5), ("100:00:00", 360000.0),
     ("2026-03-12 09:14", MORNING - 3), ("12.03.2026 09:14", MORNING - 3)],
)  # fmt: skip
def test_clocks(cell: str, seconds: float) -> None:
    assert moment(cell) == seconds


@pytest.mark.parametrize(
    "cell",
    ["", "12.03", "12.03.2026", "31.02.2026 00:00:00", "2026-13-01 00:00:00", "13:00:00 PM", "0:10:00 AM",
     "2026-03-12 24:10:00", "12-Mxr-2026 09:14:03", "1.2.3", "2026112 09:14:03", "03/12/2026 09:14:03", "1:2"],
)  # fmt: skip
def test_what_is_no_date_or_one_of_two(cell: str) -> None:
    assert moment(cell) is None


def test_the_order_of_day_and_month_decides() -> None:
    cell = "03/12/2026 09:14:03"
    assert moment(cell, DateOrder.MONTH_FIRST) == MORNING
    assert moment(cell, DateOrder.DAY_FIRST) == datetime(2026, 12, 3, 9, 14, 3, tzinfo=UTC).timestamp()


def written(tmp_path: Path, form: str, first: float = MORNING, rows: int = 60) -> Path:
    times = [datetime.fromtimestamp(first + i, UTC).strftime(form) for i in range(rows)]
    lines = [f"{time},{i % 3},{i % 5},{i % 7}" for i, time in enumerate(times)]
    (file := tmp_path / "log.csv").write_text("\n".join(["local time,gx [dps],gy [dps],gz [dps]", *lines]) + "\n")
    return file


@pytest.mark.parametrize(
    ("form", "first"),
    [("%d.%m.%Y %H:%M:%S", MORNING), ("%d/%m/%Y %H:%M:%S", MORNING + 86400),
     ("%m/%d/%Y %I:%M:%S %p", MORNING + 86400), ("%d-%m-%Y %H:%M:%S", MORNING + 86400),
     ("%d-%b-%Y %H:%M:%S", MORNING)],
)  # fmt: skip
def test_dates_of_a_log(form: str, first: float, tmp_path: Path) -> None:
    file = written(tmp_path, form, first)
    for table in (read_table(file), open_table(file).head):
        assert table.moments == {"local time"}
        assert np.array_equal(table.column("local time"), first + np.arange(60))
    assert choose_columns(read_table(file), ColumnOptions()).time == "local time"


@pytest.mark.parametrize("form", ["%m/%d/%Y %H:%M:%S", "%d/%m/%Y %H:%M:%S", "%d-%m-%Y %H:%M"])
def test_a_date_of_two_readings_is_asked_for_with_both(form: str, tmp_path: Path) -> None:
    table = read_table(written(tmp_path, form))
    with refused(DataRefused, ErrorCode.COLUMNS, "2026-03-12", "2026-12-03", "--rate", line=2):
        choose_columns(table, ColumnOptions())
    assert choose_columns(table, ColumnOptions(rate_hz=1.0)).time is None


def test_a_time_that_nobody_can_read_names_what_can_be(tmp_path: Path) -> None:
    with refused(DataRefused, ErrorCode.COLUMNS, "ISO 8601", "--rate", line=2):
        choose_columns(read_table(written(tmp_path, "%A %H o'clock")), ColumnOptions())


def test_a_column_of_dates_next_to_one_of_clocks_is_not_the_time(tmp_path: Path) -> None:
    lines = "\n".join(f"12.03.2026;09:14:{i:02d};{i % 3},5" for i in range(60))
    (file := tmp_path / "log.csv").write_text(f"Date;Time;gz [dps]\n{lines}\n")
    assert choose_columns(read_table(file), ColumnOptions()).time == "Time"


@pytest.mark.parametrize("form", ["%d.%m.%Y %H:%M:%S", "%Y-%m-%d %H:%M:%S", "%H:%M:%S"])
def test_a_clock_that_is_set_back_is_named_as_the_file_writes_it(form: str, tmp_path: Path) -> None:
    summer = datetime(2025, 10, 26, 2, 59, 30, tzinfo=UTC).timestamp()
    before, after = (written(tmp_path, form, at, 30).read_text().splitlines() for at in (summer, summer - 3570))
    (tmp_path / "log.csv").write_text("\n".join([*before, *after[1:]]) + "\n")
    found = choose_columns(read_table(tmp_path / "log.csv"), ColumnOptions())
    texts = [line.partition(",")[0] for line in (before[-1], after[1])]
    with refused(DataRefused, ErrorCode.TIME_ORDER, *texts, "3600 s", "summer time", "--rate", line=32):
        log_data(found, None, "log.csv")


def test_a_clock_that_is_set_back_by_another_time_is_no_end_of_summer_time(tmp_path: Path) -> None:
    lines = [written(tmp_path, "%Y-%m-%d %H:%M:%S", MORNING - 1000 * k).read_text().splitlines() for k in (0, 1)]
    (tmp_path / "log.csv").write_text("\n".join([*lines[0], *lines[1][1:]]) + "\n")
    found = choose_columns(read_table(tmp_path / "log.csv"), ColumnOptions())
    with refused(DataRefused, ErrorCode.TIME_ORDER, "2026-03-12 09:15:02") as caught:
        log_data(found, None, "log.csv")
    assert "summer" not in str(caught.value)
