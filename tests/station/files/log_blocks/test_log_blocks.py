"""A table that is read block by block has the rows of the file, wherever blocks end."""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from station.errors import DataRefused
from station.files.log_blocks.log_blocks import LogBlocks
from station.files.log_blocks.npz_blocks import npz_blocks
from station.files.log_blocks.text_blocks import text_blocks
from tests.refusals import refused

OF_TEXT = import_module(text_blocks.__module__)  # the package has functions of these names
OF_ARRAYS = import_module(npz_blocks.__module__)
ROWS = np.column_stack((0.25 * np.arange(30), 10.0**7 + np.arange(30), np.arange(30) % 7 - 3.5))


def rows_of(found: LogBlocks) -> np.ndarray:
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
    monkeypatch.setattr(OF_TEXT, "READ_BYTES", at_once)
    (tmp_path / "log.csv").write_text("\n".join(["t,gx,ax", *(f"{a},{b:.0f},{c}" for a, b, c in ROWS)]))
    found = text_blocks(tmp_path / "log.csv")
    assert np.array_equal(rows_of(found), ROWS)
    head = np.column_stack(list(found.head.columns.values()))
    assert len(head) in {2, 3, 4, 5, 6}
    assert np.array_equal(head, ROWS[: len(head)])
    lines = [line for block in found.read(["t"]) for line in block.lines or ()]
    assert lines == list(range(2, 32))


def test_a_line_without_an_end_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(OF_TEXT, "READ_BYTES", 64)
    monkeypatch.setattr(OF_TEXT, "MAX_LINE", 100)
    (tmp_path / "log.csv").write_text("t,gx\n" + "\n".join(["1,2"] * 30) + "\n" + "1" * 500)
    found = text_blocks(tmp_path / "log.csv")
    with refused(DataRefused, None, "1 MiB"):
        list(found.read(["t"]))


def npz(file: Path) -> LogBlocks:
    np.savez(file, t=ROWS[:, :1], data=ROWS[:, 1:], text=np.array(["a"] * 30))
    return npz_blocks(file)


def npz_of_channels(file: Path) -> LogBlocks:
    np.savez(file, t=ROWS[:, 0], data=np.ascontiguousarray(ROWS[:, 1:].T))
    return npz_blocks(file)


def npz_of_fields(file: Path) -> LogBlocks:
    table = np.zeros(30, [("t", "<f8"), ("data", "<f8", 2)])
    table["t"], table["data"] = ROWS[:, 0], ROWS[:, 1:]
    np.savez(file, table)
    return npz_blocks(file)


@pytest.mark.parametrize(
    ("write", "names"),
    [
        (npz, ["t", "data:1", "data:2"]),
        (npz_of_channels, ["t", "data:1", "data:2"]),
        (npz_of_fields, ["arr_0.t", "arr_0.data:1", "arr_0.data:2"]),
    ],
)
def test_arrays_are_read_some_rows_at_a_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write: Callable[[Path], LogBlocks], names: list[str]
) -> None:
    for name, size in {"BLOCK_ROWS": 8, "HEAD_ROWS": 5, "READ_BYTES": 50}.items():
        monkeypatch.setattr(OF_ARRAYS, name, size)
    found = write(tmp_path / "log.npz")
    assert list(found.head.columns) == names
    assert np.array_equal(np.column_stack(list(found.head.columns.values())), ROWS[:5])
    assert np.array_equal(rows_of(found), ROWS)
