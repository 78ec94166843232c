"""``.mat``, ``.npz`` and ``.parquet``: matrices by column, structures by name, what holds no numbers refused."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from procedures.arrays import FloatArray
from station.errors import DataRefused
from station.files.tables.binary_tables import open_arrays
from station.files.tables.reader import read_table
from tests.refusals import refused

T = np.arange(50) * 0.01
FILE = Path("log.mat")
ACC = np.random.default_rng(1).standard_normal((50, 3))


def columns_of(arrays: Mapping[str, object]) -> Mapping[str, FloatArray]:
    return open_arrays(arrays, FILE).whole().columns


def test_npz_matrices_by_column_either_way_round(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", t=T, acc=ACC, gyro=ACC.T, note=np.array("text"), few=np.arange(3))
    found = read_table(tmp_path / "a.npz")
    assert list(found.columns) == ["t", "acc:1", "acc:2", "acc:3", "gyro:1", "gyro:2", "gyro:3"]
    assert found.column("acc:2") == pytest.approx(ACC[:, 1])
    assert found.column("gyro:3") == pytest.approx(ACC[:, 2])
    assert found.line(3) == 4


def test_mat_variables_and_fields_of_structures(tmp_path: Path) -> None:
    savemat(
        tmp_path / "a.mat", {"t": T[:, None], "imu": {"acc": ACC, "name": "x"}, "data": np.column_stack((T, ACC))}
    )
    found = read_table(tmp_path / "a.mat")
    assert found.column("t") == pytest.approx(T)
    assert found.column("imu.acc:3") == pytest.approx(ACC[:, 2])
    assert found.column("data:2") == pytest.approx(ACC[:, 0])


def test_parquet_columns(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    moment = (T * 1e9).astype("datetime64[ns]")
    parquet.write_table(pyarrow.table({"t": moment, "ax": ACC[:, 0], "who": ["me"] * 50}), tmp_path / "a.parquet")
    found = read_table(tmp_path / "a.parquet")
    assert list(found.columns) == ["t", "ax"]
    assert found.column("t") == pytest.approx(T)


def test_moments_that_are_missing_are_no_number(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    moment = (T * 1e9).astype("datetime64[ns]")
    moment[7] = np.datetime64("NaT")
    parquet.write_table(pyarrow.table({"t_ms": moment, "ax": ACC[:, 0]}), tmp_path / "a.parquet")
    np.savez(tmp_path / "b.npz", t_ms=moment, ax=ACC[:, 0])
    for name in ("a.parquet", "b.npz"):
        found = read_table(tmp_path / name)
        assert np.flatnonzero(np.isnan(found.column("t_ms"))).tolist() == [7]
        assert found.column("t_ms")[8] == pytest.approx(T[8])
        assert found.moments == {"t_ms"}


def test_a_npy_by_another_name_fields_of_a_structure_and_no_objects(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", ACC)
    (tmp_path / "a.npy").rename(tmp_path / "a.npz")
    assert read_table(tmp_path / "a.npz").column("data:2") == pytest.approx(ACC[:, 1])
    objects = np.array([{"a": 1}, None], dtype=object)
    rows = np.array(list(zip(T, ACC[:, 0], strict=True)), dtype=[("t", "f8"), ("ax", "f4")])
    np.savez(tmp_path / "b.npz", log=rows, settings=objects)
    found = read_table(tmp_path / "b.npz")
    assert list(found.columns) == ["log.t", "log.ax"]
    assert "settings" in found.notes[0]


@pytest.mark.parametrize("name", ["a.mat", "a.npz", "a.parquet"])
@pytest.mark.parametrize("content", [b"", bytes(range(256)) * 8])
def test_damaged_files_are_refused_in_one_line(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    with refused(DataRefused, None, name):
        read_table(tmp_path / name)


def test_a_mat_of_version_7_3_says_how_to_save_it(tmp_path: Path) -> None:
    header = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    (tmp_path / "a.mat").write_bytes(header + bytes(512))
    with refused(DataRefused, None, "7.3", "-v7"):
        read_table(tmp_path / "a.mat")


def test_arrays_without_numbers_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", note=np.array("text"))
    with refused(DataRefused, None, "note"):
        read_table(tmp_path / "a.npz")


def test_vectors_and_matrices_become_columns_a_row_a_sample() -> None:
    wide = np.arange(12.0).reshape(3, 4)  # a row a channel
    flag, one = np.array([True, False, True, True]), np.arange(4.0)[:, None]
    found = columns_of({"t": np.arange(4), "acc": wide, "flag": flag, "one": one})
    assert {name: column.tolist() for name, column in found.items()} == {
        "t": [0.0, 1.0, 2.0, 3.0], "acc:1": [0.0, 1.0, 2.0, 3.0], "acc:2": [4.0, 5.0, 6.0, 7.0],
        "acc:3": [8.0, 9.0, 10.0, 11.0], "flag": [1.0, 0.0, 1.0, 1.0], "one": [0.0, 1.0, 2.0, 3.0],
    }  # fmt: skip
    assert all(column.flags.c_contiguous for column in found.values())


def test_a_square_matrix_lies_a_row_a_sample() -> None:
    found = columns_of({"C": [[1.0, 2.0], [3.0, 4.0]]})
    assert found["C:1"].tolist() == [1.0, 3.0]


def test_what_is_shorter_than_the_longest_or_no_number_is_left_out() -> None:
    found = columns_of(
        {
            "t": np.arange(5), "rate": np.array(100.0), "short": np.arange(4), "text": np.array(["a"] * 5),
            "cube": np.zeros((5, 2, 2)), "empty": np.zeros(0), "complex": np.zeros(5, complex),
        }
    )  # fmt: skip
    assert list(found) == ["t"]


@pytest.mark.parametrize("arrays", [{}, {"x": np.array(["a", "b"])}, {"x": [1.0]}])
def test_without_two_rows_of_numbers_it_is_refused(arrays: dict[str, object]) -> None:
    with refused(DataRefused):
        columns_of(arrays)
    assert columns_of({"x": [1.0, 2.0]})["x"].tolist() == [1.0, 2.0]
