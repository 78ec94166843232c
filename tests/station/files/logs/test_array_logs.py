"""``.mat``, ``.npz`` and ``.parquet``: matrices by column, structures by name, what holds no numbers refused."""

from datetime import time
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from station.errors import DataRefused
from station.files.logs import read_log

T = np.arange(50) * 0.01
ACC = np.random.default_rng(1).standard_normal((50, 3))


def test_npz_matrices_by_column_either_way_round(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", t=T, acc=ACC, gyro=ACC.T, note=np.array("text"), few=np.arange(3))
    found = read_log(tmp_path / "a.npz")
    assert list(found.columns) == ["t", "acc:1", "acc:2", "acc:3", "gyro:1", "gyro:2", "gyro:3"]
    assert found.column("acc:2") == pytest.approx(ACC[:, 1])
    assert found.column("gyro:3") == pytest.approx(ACC[:, 2])
    assert found.line(3) is None


def test_mat_variables_and_fields_of_structures(tmp_path: Path) -> None:
    savemat(
        tmp_path / "a.mat", {"t": T[:, None], "imu": {"acc": ACC, "name": "x"}, "data": np.column_stack((T, ACC))}
    )
    found = read_log(tmp_path / "a.mat")
    assert found.column("t") == pytest.approx(T)
    assert found.column("imu.acc:3") == pytest.approx(ACC[:, 2])
    assert found.column("data:2") == pytest.approx(ACC[:, 0])


def test_parquet_columns(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    moment = (T * 1e9).astype("datetime64[ns]")
    parquet.write_table(pyarrow.table({"t": moment, "ax": ACC[:, 0], "who": ["me"] * 50}), tmp_path / "a.parquet")
    found = read_log(tmp_path / "a.parquet")
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
        found = read_log(tmp_path / name)
        assert np.flatnonzero(np.isnan(found.column("t_ms"))).tolist() == [7]
        assert found.column("t_ms")[8] == pytest.approx(T[8])
        assert found.moments == {"t_ms"}


def test_parquet_times_of_the_day_and_decimals_are_numbers(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    clocks = [time(10, 0, i, 500_000) for i in range(50)]
    exact = [Decimal(f"{x:.2f}") for x in T]
    parquet.write_table(pyarrow.table({"clock": clocks, "ax": exact}), tmp_path / "a.parquet")
    found = read_log(tmp_path / "a.parquet")
    assert found.column("clock") == pytest.approx(36000.5 + np.arange(50))
    assert found.column("ax") == pytest.approx(T)


def test_a_npy_by_another_name_fields_of_a_structure_and_no_objects(tmp_path: Path) -> None:
    np.save(tmp_path / "a.npy", ACC)
    (tmp_path / "a.npy").rename(tmp_path / "a.npz")
    assert read_log(tmp_path / "a.npz").column("data:2") == pytest.approx(ACC[:, 1])
    objects = np.array([{"a": 1}, None], dtype=object)
    rows = np.array(list(zip(T, ACC[:, 0], strict=True)), dtype=[("t", "f8"), ("ax", "f4")])
    np.savez(tmp_path / "b.npz", log=rows, settings=objects)
    found = read_log(tmp_path / "b.npz")
    assert list(found.columns) == ["log.t", "log.ax"]
    assert found.notes == ("settings of Python objects: left out",)


@pytest.mark.parametrize("name", ["a.mat", "a.npz", "a.parquet"])
@pytest.mark.parametrize("content", [b"", b"no such thing", bytes(range(256)) * 8])
def test_damaged_files_are_refused_in_one_line(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(DataRefused) as raised:
        read_log(tmp_path / name)
    assert name in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_mat_of_version_7_3_says_how_to_save_it(tmp_path: Path) -> None:
    header = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    (tmp_path / "a.mat").write_bytes(header + bytes(512))
    with pytest.raises(DataRefused, match=r"version 7.3.*-v7"):
        read_log(tmp_path / "a.mat")


def test_arrays_without_numbers_are_refused(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", note=np.array("text"))
    with pytest.raises(DataRefused, match="found note, expected arrays of numbers"):
        read_log(tmp_path / "a.npz")
