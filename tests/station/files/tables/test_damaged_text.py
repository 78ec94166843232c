"""Text logs with the damage that serial lines, cards and spreadsheets do; the same by blocks as at once."""

import random
from pathlib import Path

import numpy as np
import pytest

from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.tables.reader import open_table, read_table
from tests.refusals import refused

N = 400
_RANDOM = random.Random(3)
HEADER = "t_ms,gx_dps,ax,temp"
ROWS = [f"{10 * i},{_RANDOM.gauss(0, 1):.5f},{_RANDOM.gauss(9.8, 0.1):.4f},{25 + i / 100:.2f}" for i in range(N)]
VALUES = np.array([[float(cell) for cell in row.split(",")] for row in ROWS])


def read(tmp_path: Path, content: str | bytes, name: str = "log.csv") -> np.ndarray:
    """Return all rows (n, columns), which blocks must give alike."""
    file = tmp_path / name
    file.write_bytes(content if isinstance(content, bytes) else content.encode())
    whole, blocks = read_table(file), open_table(file)
    assert list(whole.columns) == list(blocks.head.columns)
    numbers = [name for name in whole.columns if name not in whole.unreadable]
    parts = list(blocks.read(numbers))
    for name in numbers:
        together = np.concatenate([part.columns[name] for part in parts])
        assert np.array_equal(together, whole.columns[name], equal_nan=True)
    return np.column_stack([whole.columns[name] for name in numbers])


def with_row(number: int, row: str) -> str:
    rows = [*ROWS]
    rows[number] = row
    return "\n".join([HEADER, *rows]) + "\n"


GLUED = ROWS[100][:12] + ROWS[101]
DAMAGED = {
    "two lines run together": GLUED,
    "a line cut": ROWS[100][:9],
    "a line cut in its last cell": ROWS[100][:-1],
    "a number cut": ROWS[100].replace(".", ".\0\0", 1),
    "garbage bytes": ROWS[100].replace(",", ",\u00ff\u00fe", 1),
    "two numbers glued": ROWS[100].replace(".", ".231.", 1),
    "a decimal point lost": ROWS[100].replace(".", "", 1),
    "a digit lost": ROWS[100].split(".")[0] + "." + ROWS[100].split(".", 1)[1][1:],
    "a delimiter lost": ROWS[100].replace(",", "", 1),
    "a message in between": "[W] watchdog: reset, reason 3",
    "a word for a number": ROWS[100].replace(ROWS[100].split(",")[1], "ovf"),
}


@pytest.mark.parametrize("what", DAMAGED)
def test_a_damaged_row_is_lost_alone_and_reported_once(what: str, tmp_path: Path) -> None:
    found = read(tmp_path, with_row(100, DAMAGED[what]))
    bad = ~np.isfinite(found).all(axis=1)
    assert np.flatnonzero(bad).tolist() == [100]
    assert np.array_equal(found[~bad], VALUES[~bad])
    table = read_table(tmp_path / "log.csv")
    assert [note for note in table.notes if "damaged" in note] == list(table.notes)
    assert "line 102" in table.notes[0]
    assert table.damaged == {100}


@pytest.mark.parametrize("what", ["two lines run together", "garbage bytes", "a decimal point lost"])
def test_damage_in_the_first_rows_is_no_other_table(what: str, tmp_path: Path) -> None:
    row = {"two lines run together": ROWS[2][:12] + ROWS[3], "garbage bytes": ROWS[2].replace(",", ",\u00ff", 1),
           "a decimal point lost": ROWS[2].replace(".", "", 1)}[what]  # fmt: skip
    found = read(tmp_path, with_row(2, row))
    assert list(read_table(tmp_path / "log.csv").columns) == HEADER.split(",")
    assert len(found) == N
    assert np.flatnonzero(~np.isfinite(found).all(axis=1)).tolist() == [2]


@pytest.mark.parametrize("every", [20, 80])
def test_many_damaged_rows_are_refused_with_the_first(every: int, tmp_path: Path) -> None:
    rows = [row[:9] if i % every == 7 else row for i, row in enumerate(ROWS)]
    with refused(DataRefused, ErrorCode.DAMAGED_ROWS, line=9):
        read(tmp_path, "\n".join([HEADER, *rows]) + "\n")
    blocks = open_table(tmp_path / "log.csv")
    with refused(DataRefused, ErrorCode.DAMAGED_ROWS, line=9):
        list(blocks.read(["t_ms"]))


def test_a_first_line_that_begins_in_the_middle_is_left_out(tmp_path: Path) -> None:
    found = read(tmp_path, "\n".join([ROWS[0][9:], *ROWS[1:]]) + "\n")
    assert np.array_equal(found, VALUES[1:])
    assert "line 1" in read_table(tmp_path / "log.csv").notes[0]


@pytest.mark.parametrize(
    "bytes_between",
    [b"", b"# pause\r\n", b"\r\n\r\n", HEADER.encode() + b"\r\n", b"\0" * 40, b"\0" * 40 + b"\r\n"],
)
def test_pauses_headers_again_and_nul_bytes_harm_nothing(bytes_between: bytes, tmp_path: Path) -> None:
    first, then = ("".join(f"{row}\r\n" for row in rows).encode() for rows in (ROWS[:200], ROWS[200:]))
    content = b"\xef\xbb\xbf" + HEADER.encode() + b"\r\n" + first + bytes_between + then
    assert np.array_equal(read(tmp_path, content), VALUES)


def test_a_degree_sign_survives_garbage_elsewhere(tmp_path: Path) -> None:
    rows = [*(row.encode() for row in ROWS[:99]), b"\xff\xfe\x90", *(row.encode() for row in ROWS[100:])]
    read(tmp_path, b"\n".join(["t [ms],gx [°/s],ax,temp [°C]".encode(), *rows]))
    assert list(read_table(tmp_path / "log.csv").columns) == ["t [ms]", "gx [°/s]", "ax", "temp [°C]"]


def semicolons(row: str) -> str:
    return row.replace(",", ";").replace(".", ",")


@pytest.mark.parametrize("above", ["", "sep=;\n", "\ufeffsep=;\r\n"])
def test_a_spreadsheet_with_decimal_commas(above: str, tmp_path: Path) -> None:
    content = above + "\n".join(map(semicolons, [HEADER, *ROWS])) + "\n"
    assert np.array_equal(read(tmp_path, content), VALUES)
    assert list(read_table(tmp_path / "log.csv").columns) == HEADER.split(",")


@pytest.mark.parametrize("decimal", [".", ","])
def test_quoted_cells(decimal: str, tmp_path: Path) -> None:
    quoted = [",".join(f'"{cell.replace(".", decimal)}"' for cell in row.split(",")) for row in ROWS]
    header = ",".join(f'"{name}"' for name in HEADER.split(","))
    assert np.array_equal(read(tmp_path, "\n".join([header, *quoted]) + "\n"), VALUES)


@pytest.mark.parametrize(
    ("cell", "delimiter"),
    [
        (lambda v: f"{v:,.2f}", ";"),  # 1,234.50
        (lambda v: f"{v:,.2f}".replace(",", "_").replace(".", ",").replace("_", "."), ";"),  # 1.234,50
        (lambda v: f"{v:,.0f}", "\t"),  # 998, 999, 1,000
        (lambda v: f'"{v:,.2f}"', ","),  # "1,234.50"
    ],
)
def test_thousands_may_be_parted(cell: object, delimiter: str, tmp_path: Path) -> None:
    assert callable(cell)
    times = 900.0 + np.arange(N)
    rows = [delimiter.join((cell(t), f"{i}")) for i, t in enumerate(times)]
    found = read(tmp_path, "\n".join([delimiter.join(("t", "ax")), *rows]) + "\n")
    assert np.array_equal(found[:, 0], times)


def test_a_column_of_hexadecimal_flags_is_text_and_costs_no_row(tmp_path: Path) -> None:
    rows = [f"{row},{16 + i % 200:02X}" for i, row in enumerate(ROWS)]
    assert np.array_equal(read(tmp_path, "\n".join([HEADER + ",flags", *rows]) + "\n")[:, :4], VALUES)
    with refused(DataRefused, None, "flags"):
        read_table(tmp_path / "log.csv").column("flags")
    with refused(DataRefused, None, "flags"):
        list(open_table(tmp_path / "log.csv").read(["flags"]))


def test_text_that_is_called_mat_is_read_as_text(tmp_path: Path) -> None:
    """As the public data of imu_tk: time and three outputs in columns parted by blanks."""
    rows = "".join(f"   {1.4e6 + 0.01 * i:.7e}   {33.1 + i % 3:.7e}   {-2.5:.7e}   {9.81:.7e}\n" for i in range(N))
    found = read(tmp_path, rows, "xsens_acc.mat")
    assert found.shape == (N, 4)
    assert found[5, 0] == pytest.approx(1.4e6 + 0.05)


GCSV = """GYROFLOW IMU LOG
version,1.3
id,my_logger
orientation,YxZ
note,bench
tscale,0.0025
gscale,0.001
ascale,0.0005
t,gx,gy,gz,ax,ay,az
"""


def test_scales_of_a_gcsv_are_those_of_its_header(tmp_path: Path) -> None:
    found = read(tmp_path, GCSV + "".join(f"{i},100,-200,{i},0,0,2000\n" for i in range(N)), "flight.gcsv")
    table = read_table(tmp_path / "flight.gcsv")
    assert list(table.columns) == [
        "t", "gx [rad/s]", "gy [rad/s]", "gz [rad/s]", "ax [g]", "ay [g]", "az [g]",
    ]  # fmt: skip
    assert table.time_scale_s == 0.0025
    assert open_table(tmp_path / "flight.gcsv").head.time_scale_s == 0.0025
    assert found[7] == pytest.approx([7, 0.1, -0.2, 0.007, 0, 0, 1.0])
    assert any("YxZ" in note for note in table.notes)
