"""Hostile CSV never crashes and never becomes data."""

import io
import math
import re
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from station.errors import DataRefused
from station.files.tables import strict_csv
from station.files.tables.strict_csv import SampleColumns, read_csv
from station.files.tables.table import Table
from tests.refusals import refused

COUNTS, REALS = SampleColumns(counts=True), SampleColumns(counts=False)
FILE = Path("x.csv")
INTEGER = re.compile(r"[+-]?[0-9]+", re.ASCII)
NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?", re.ASCII)


def read(content: bytes, kind: SampleColumns = COUNTS) -> Table:
    stream = io.BytesIO(content)
    return read_csv(stream, FILE, kind)  # type: ignore[arg-type]


@given(st.binary(max_size=300))
def test_arbitrary_bytes_are_refused(content: bytes) -> None:
    with pytest.raises(DataRefused):
        read(content)


@given(st.lists(st.text('0123456789+-.eE_xnai ,"\r\n\t\0\u0663', max_size=12), min_size=1, max_size=8))
@example([" "])
def test_arbitrary_rows_are_refused_or_mean_what_python_reads(rows: list[str]) -> None:
    content = "t_s,gx,gy,gz\n" + "".join(f"{i},1,{row},3\n" for i, row in enumerate(rows))
    legal = all(INTEGER.fullmatch(row) and abs(int(row)) < 2**53 for row in rows)
    if not any(rows):  # a channel that the device does not have
        assert not read(content.encode()).columns["gy"].any()
    elif not legal:
        with pytest.raises(DataRefused):
            read(content.encode())
    else:
        assert read(content.encode()).columns["gy"].tolist() == [int(row) for row in rows]


def test_a_column_empty_in_every_row_is_a_channel_that_is_not_there() -> None:
    table = read(b"t_s,gx,gy,gz,ax,ay,az\n0,1,,,,,\n1,2,,,,,\n")
    assert {name: column.tolist() for name, column in table.columns.items()} == {
        "t_s": [0, 1], "gx": [1, 2], "gy": [0, 0], "gz": [0, 0],
    }  # fmt: skip
    with refused(DataRefused, None, "'5'", "gy"):
        read(b"t_s,gx,gy,gz\n0,1,,3\n1,2,5,3\n")
    with refused(DataRefused, None, "gy", line=3):
        read(b"t_s,gx,gy,gz\n0,1,4,3\n1,2,,3\n")
    with refused(DataRefused):
        read(b"t_s,gx,gy,gz\n0,,,\n")


def test_a_rate_table_has_the_outputs_that_are_not_empty_and_no_others() -> None:
    table = read(b"rate_ref_deg_s,gx,gy,gz\n10,1,,3\n-10,2,,4\n", SampleColumns(counts=False, rate_table=True))
    assert {name: column.tolist() for name, column in table.columns.items()} == {
        "rate_ref_deg_s": [10, -10], "gx": [1, 2], "gz": [3, 4],
    }  # fmt: skip


@given(st.from_regex(NUMBER, fullmatch=True))
@example("1e308")
@example("1.7976931348623157e308")
@example("4.9e-324")
def test_a_real_is_rounded_as_python_rounds_it(cell: str) -> None:
    content = f"t_s,gx,gy,gz\n0,{cell},1,1\n".encode()
    if abs(value := float(cell)) >= 1.7976931348623157e308:
        with pytest.raises(DataRefused):
            read(content, REALS)
    else:
        assert read(content, REALS).columns["gx"][0] == value


@given(st.integers(1, 40), st.integers(0, 30), st.booleans(), st.booleans())
def test_the_line_is_right_however_the_file_is_cut_into_blocks(
    size: int, good: int, crlf: bool, last: bool
) -> None:
    end = "\r\n" if crlf else "\n"
    rows = [f"{i},{i},-2,3" for i in range(good)] + ["9999,1,oops,1"] + ([] if last else ["10000,1,1,1"])
    content = end.join(["t_s,gx,gy,gz", *rows]) + ("" if last else end)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(strict_csv, "_BLOCK", size)
        with refused(DataRefused, None, "'oops'", "gy", line=good + 2):
            read(content.encode())
        table = read(content.replace("oops", "7").encode())
    assert table.columns["t_s"].tolist() == [*range(good), 9999, *([] if last else [10000])]


@given(st.lists(st.tuples(st.booleans(), st.booleans(), st.booleans()), min_size=1, max_size=5))
def test_empty_cells_stay_where_they_are(present: list[tuple[bool, bool, bool]]) -> None:
    rows = [",".join("5" if there else "" for there in row) for row in present]
    lines = [f"{a},{i},1,1,1,{b},{c}" for i, (a, b, c) in enumerate(row.split(",") for row in rows)]
    table = read("\n".join(["aux_a,t_s,gx,gy,gz,aux_b,temp_c", *lines]).encode())
    got = [
        [not math.isnan(table.columns[name][i]) for name in ("aux_a", "aux_b", "temp_c")] for i in range(len(rows))
    ]
    assert got == [list(row) for row in present]


def test_a_file_without_an_end_of_line_keeps_its_memory_bounded() -> None:
    with refused(DataRefused, None, "1 MiB"):
        read(b"t_s,gx,gy,gz\n" + b"1" * (9 * 2**20))
