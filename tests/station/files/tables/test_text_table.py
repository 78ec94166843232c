"""Text logs as people have them: any delimiter, headers or none, lines above the table, decimal commas."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.tables.reader import read_table
from tests.refusals import refused

ROWS = [[0.1 * i, i - 5.5, 1e-3 * i] for i in range(20)]


def text(delimiter: str, header: str = "", rows: list[list[float]] = ROWS) -> str:
    return header + "\n".join(delimiter.join(f"{cell:.6g}" for cell in row) for row in rows) + "\n"


def written(tmp_path: Path, content: str | bytes, name: str = "log.csv") -> Path:
    file = tmp_path / name
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    return file


@pytest.mark.parametrize("delimiter", [",", ";", "\t", "|", "   ", " ; "])
@pytest.mark.parametrize("header", ["", "t{}a{}b\n", '"t"{}"a"{}"b"\r\n', "# t{}a{}b\n", "% of my logger 2\n"])
def test_any_delimiter_with_or_without_a_header(tmp_path: Path, delimiter: str, header: str) -> None:
    found = read_table(written(tmp_path, text(delimiter, header.replace("{}", delimiter))))
    names = ["t", "a", "b"] if "{}" in header else ["1", "2", "3"]
    assert list(found.columns) == names
    assert np.stack(list(found.columns.values()), axis=1) == pytest.approx(np.array(ROWS), rel=1e-6)
    assert found.line(0) == 1 + bool(header)


def test_decimal_commas_and_a_byte_order_mark(tmp_path: Path) -> None:
    content = "\ufefft;a;b\r\n" + text(";").replace(".", ",").replace("\n", "\r\n")
    found = read_table(written(tmp_path, content))
    assert found.columns["a"] == pytest.approx([row[1] for row in ROWS])
    assert "decimal commas" in found.notes


def test_columns_by_name_by_bare_name_in_any_case_and_by_number(tmp_path: Path) -> None:
    found = read_table(written(tmp_path, text(",", "time [s],Acc_X [m/s^2],3\n")))
    assert [found.name_of(key) for key in ("time", "acc_x", "2", "1")] == [
        "time [s]", "Acc_X [m/s^2]", "Acc_X [m/s^2]", "time [s]",
    ]  # fmt: skip
    assert found.name_of("3") == "3"
    with refused(DataRefused, ErrorCode.COLUMNS, "'gx'", "time [s]"):
        found.name_of("gx")


@pytest.mark.parametrize(
    ("cells", "first", "step"),
    [
        (lambda i: f"2026-05-11T10:00:{i:02d}.250Z", 1778493600.25, 1.0),
        (lambda i: f"2026-05-11 12:00:{i:02d},250+02:00", 1778493600.25, 1.0),
        (lambda i: f"2026/05/11 10:00:{i:02d}", 1778493600.0, 1.0),
        (lambda i: f"23:59:{i:02d}.5", 86340.5, 1.0),
    ],
)
def test_dates_and_clocks_are_seconds(
    tmp_path: Path, cells: Callable[[int], str], first: float, step: float
) -> None:
    lines = "\n".join(f"{cells(i)};{0.5 * i}" for i in range(20))
    found = read_table(written(tmp_path, f"moment;rate\n{lines}\n"))
    assert found.column("moment") == pytest.approx(first + step * np.arange(20), rel=1e-15)
    assert found.moments == {"moment"}


def test_a_degree_sign_of_another_encoding_and_a_row_of_units(tmp_path: Path) -> None:
    units = "s\t°/s\t-\n".encode("latin-1")
    found = read_table(written(tmp_path, b"t\tgx\tcount\n" + units + text("\t").encode()))
    assert list(found.columns) == ["t [s]", "gx [°/s]", "count"]
    assert (found.rows, found.line(0)) == (20, 3)
    named = read_table(written(tmp_path, "t;gx [°/s];b\n".encode("latin-1") + text(";").encode()))
    assert list(named.columns) == ["t", "gx [°/s]", "b"]


@pytest.mark.parametrize(
    ("units", "expected"),
    [("us\t\tm.s^-2\tdeg.s^-1\tdeg C", ["us", "", "m.s^-2", "deg.s^-1", "deg C"]),
     ("s\t-\tm/s2\trad/s\thPa", ["s", "", "m/s2", "rad/s", "hPa"]),
     ("[ms]\t[uT]\t[mg]\t[dps]\t", ["ms", "uT", "mg", "dps", ""])],
)  # fmt: skip
def test_a_row_of_units_below_the_names_is_put_behind_them(
    tmp_path: Path, units: str, expected: list[str]
) -> None:
    names = ["Timestamp", "Status", "Accel X", "Gyro X", "Temp"]
    rows = "".join(f"{i}\t7\t9.8{i % 7}\t0.{i % 3}\t25.{i % 9}\n" for i in range(20))
    (tmp_path / "log.txt").write_text("\t".join(names) + f"\n{units}\n{rows}")
    found = list(read_table(tmp_path / "log.txt").columns)
    assert found == [f"{name} [{unit}]" if unit else name for name, unit in zip(names, expected, strict=True)]


@pytest.mark.parametrize(
    ("last", "is_named"), [("Comment", True), ("Remarks", True), ("", True), ("\t\t", True), ("gz", False)]
)
def test_a_column_of_remarks_that_the_rows_lack_costs_no_names(tmp_path: Path, last: str, is_named: bool) -> None:
    rows = "".join(f"0.{i:02}\t1.{i}\t2.{i}\n" for i in range(20))
    (tmp_path / "log.lvm").write_text(f"***End_of_Header***\nX_Value\tgx\tgy\t{last}\n{rows}")
    assert list(read_table(tmp_path / "log.lvm").columns) == (
        ["X_Value", "gx", "gy"] if is_named else ["1", "2", "3"]
    )


@pytest.mark.parametrize(
    ("row", "expected"),
    [
        ("%RAWIMUSA,2105,425384.180;2105,64546,{}*04068385", "%"),
        ("# {} 1 2 3", "#"),
        ("0x0004{:04X},0xFFFE63DE", "0x"),
    ],
)
def test_rows_that_look_like_comments_or_are_hexadecimal_are_named(
    tmp_path: Path, row: str, expected: str
) -> None:
    (tmp_path / "log.txt").write_text("".join(f"{row.format(i)}\n" for i in range(300)))
    with refused(DataRefused, ErrorCode.TABLE, expected):
        read_table(tmp_path / "log.txt")


def test_empty_cells_are_no_number_and_comments_and_empty_lines_no_row(tmp_path: Path) -> None:
    lines = text(",", "t,a,b\n").splitlines()
    lines[5] = "0.4,,N/A"
    found = read_table(written(tmp_path, "\n".join([*lines[:8], "", "# pause", *lines[8:]])))
    assert found.rows == 20
    assert np.isnan(found.columns["a"][4])
    assert found.line(7) == 11


def test_a_last_line_cut_short_is_left_out_and_reported(tmp_path: Path) -> None:
    found = read_table(written(tmp_path, text(",") + "2.0,1"))
    assert found.rows == 20
    assert "line 21" in found.notes[0]


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (b"", ErrorCode.TABLE), (b"hello\nworld\n", ErrorCode.TABLE), (b"\x00\x01\x02" * 100, ErrorCode.TABLE),
        (text(",").replace("0.5,", "0.5,7,", 1).encode(), ErrorCode.DAMAGED_ROWS),
    ],
)  # fmt: skip
def test_what_is_no_table_is_refused(tmp_path: Path, content: bytes, code: ErrorCode) -> None:
    with refused(DataRefused, code):
        read_table(written(tmp_path, content))


@given(st.binary(max_size=300))
def test_no_bytes_crash_the_reader(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    file = written(tmp_path_factory.getbasetemp(), content)
    reported, rows = "", 1
    try:
        rows = read_table(file).rows
    except DataRefused as error:
        reported = str(error)
    assert rows > 0
    assert "\n" not in reported
