"""A table that is read block by block has the rows of the file, wherever blocks end."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow
import pytest
from pyarrow import feather, parquet

from station.errors import DataRefused
from station.files.tables import binary_tables, text_table
from station.files.tables.reader import open_table, read_table
from station.files.tables.table import TableReader
from tests.refusals import refused

ROWS = np.column_stack((0.25 * np.arange(30), 10.0**7 + np.arange(30), np.arange(30) % 7 - 3.5))


def rows_of(found: TableReader) -> np.ndarray:
    """Return the rows of all blocks, which must say how far they are."""
    blocks = list(found.read(list(found.head.columns)))
    done = [each.done for each in blocks]
    assert len(blocks) > 3
    assert done == sorted(done)
    assert done[0] == pytest.approx(len(next(iter(blocks[0].columns.values()))) / len(ROWS), abs=0.04)
    assert done[-1] == 1.0
    return np.concatenate([np.column_stack(list(each.columns.values())) for each in blocks])


@pytest.mark.parametrize("at_once", [70, 71, 83, 130])
def test_text_is_cut_between_lines_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, at_once: int) -> None:
    monkeypatch.setattr(text_table, "READ_BYTES", at_once)
    (tmp_path / "log.csv").write_text("\n".join(["t,gx,ax", *(f"{a},{b:.0f},{c}" for a, b, c in ROWS)]))
    found = open_table(tmp_path / "log.csv")
    assert np.array_equal(rows_of(found), ROWS)
    head = np.column_stack(list(found.head.columns.values()))
    assert len(head) in {2, 3, 4, 5, 6}
    assert np.array_equal(head, ROWS[: len(head)])
    lines = [line for block in found.read(["t"]) for line in block.lines]
    assert lines == list(range(2, 32))


def test_a_line_without_an_end_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text_table, "READ_BYTES", 64)
    monkeypatch.setattr(text_table, "MAX_LINE", 100)
    (tmp_path / "log.csv").write_text("t,gx\n" + "\n".join(["1,2"] * 30) + "\n" + "1" * 500)
    found = open_table(tmp_path / "log.csv")
    with refused(DataRefused, None, "1 MiB"):
        list(found.read(["t"]))


def npz(file: Path) -> TableReader:
    np.savez(file, t=ROWS[:, :1], data=ROWS[:, 1:], text=np.array(["a"] * 30))
    return open_table(file)


def npz_of_channels(file: Path) -> TableReader:
    np.savez(file, t=ROWS[:, 0], data=np.ascontiguousarray(ROWS[:, 1:].T))
    return open_table(file)


def npz_of_fields(file: Path) -> TableReader:
    table = np.zeros(30, [("t", "<f8"), ("data", "<f8", 2)])
    table["t"], table["data"] = ROWS[:, 0], ROWS[:, 1:]
    np.savez(file, table)
    return open_table(file)


@pytest.mark.parametrize(
    ("write", "names"),
    [
        (npz, ["t", "data:1", "data:2"]),
        (npz_of_channels, ["t", "data:1", "data:2"]),
        (npz_of_fields, ["arr_0.t", "arr_0.data:1", "arr_0.data:2"]),
    ],
)
def test_arrays_are_read_some_rows_at_a_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write: Callable[[Path], TableReader], names: list[str]
) -> None:
    for name, size in {"BLOCK_ROWS": 8, "HEAD_ROWS": 5, "READ_BYTES": 50}.items():
        monkeypatch.setattr(binary_tables, name, size)
    found = write(tmp_path / "log.npz")
    assert list(found.head.columns) == names
    assert np.array_equal(np.column_stack(list(found.head.columns.values())), ROWS[:5])
    assert np.array_equal(rows_of(found), ROWS)


@pytest.mark.parametrize("suffix", ["parquet", "feather"])
def test_tables_of_arrow_are_read_some_rows_at_a_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    monkeypatch.setattr(binary_tables, "BLOCK_ROWS", 8)
    monkeypatch.setattr(binary_tables, "HEAD_ROWS", 5)
    table = pyarrow.table({"t": ROWS[:, 0], "who": ["me"] * 30, "n": ROWS[:, 1].astype(int), "ax": ROWS[:, 2]})
    file = tmp_path / f"log.{suffix}"
    if suffix == "parquet":
        parquet.write_table(table, file)
    else:
        feather.write_feather(table, file, chunksize=10)
    found = open_table(file)
    assert list(found.head.columns) == ["t", "n", "ax"]
    assert np.array_equal(np.column_stack(list(found.head.columns.values())), ROWS[:5])
    assert np.array_equal(rows_of(found), ROWS)
    assert np.array_equal(np.column_stack(list(read_table(file).columns.values())), ROWS)


def test_a_last_line_cut_short_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text_table, "READ_BYTES", 70)
    (tmp_path / "log.csv").write_text("\n".join(["t,gx,ax", *(f"{a},{b:.0f},{c}" for a, b, c in ROWS), "7.5,1"]))
    assert np.array_equal(rows_of(open_table(tmp_path / "log.csv")), ROWS)
