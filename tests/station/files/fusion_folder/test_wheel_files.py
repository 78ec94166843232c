"""The wheel of a fusion folder: read from its own file or the IMU's, refused in one line where it is wrong."""

from pathlib import Path

import numpy as np
import pytest

from station.errors import DataRefused
from station.files.fusion_folder import read_fusion
from station.files.fusion_folder.fusion_reading import files_of
from tests.station.files.fusion_folder.folders import TOML, write_folder

TABLE = '[wheel]\nfile = "wheel.csv"\n'
TIMES = np.arange(0.0, 19.9, 0.05)
GNSS_SPEED = np.hypot(5 * 0.4 * np.cos(0.4 * TIMES), 3 * 0.8 * np.cos(0.8 * TIMES))


def with_wheel(folder: Path, table: str = TABLE, rows: str | None = None) -> Path:
    write_folder(folder)
    (folder / "fusion.toml").write_text(TOML + table)
    told = zip(TIMES.tolist(), GNSS_SPEED.tolist(), strict=True)
    (folder / "wheel.csv").write_text(rows or "t_s,wheel_m_s\n" + "".join(f"{t:.3f},{v:.4f}\n" for t, v in told))
    return folder


def test_a_wheel_of_its_own_file_is_read(tmp_path: Path) -> None:
    log = read_fusion(with_wheel(tmp_path / "log"))
    assert log.wheel is not None
    assert np.allclose(log.wheel.speed, GNSS_SPEED, atol=1e-4)
    assert (tmp_path / "log" / "wheel.csv") in files_of(tmp_path / "log")


def test_a_column_of_the_imu_is_read_where_its_cells_are_not_empty(tmp_path: Path) -> None:
    folder = with_wheel(tmp_path / "log", "[wheel]\nscale_std = 0.02\nforward = [0, 1, 0]\n")
    head, *rows = (folder / "imu.csv").read_text().splitlines()
    told = [f"{row},{2 + i / 100 if i % 2 else ''}" for i, row in enumerate(rows[:200])]
    (folder / "imu.csv").write_text("\n".join([head + ",wheel_m_s", *told]) + "\n")
    log = read_fusion(folder)
    assert log.wheel is not None
    assert log.imu is not None
    assert np.allclose(log.wheel.speed, 2 + np.arange(1, 200, 2) / 100)
    assert np.array_equal(log.wheel.t, log.imu.t[1:200:2])


ROWS = "t_s,wheel_m_s\n0.0,1.0\n"
WRONG = {
    "nan": (TABLE, ROWS + "0.1,nan\n", "wheel.csv:3: found 'nan' in column wheel_m_s, expected a number"),
    "empty": (TABLE, ROWS + "0.1,\n", "wheel.csv:3: found '' in column wheel_m_s"),
    "backwards": (TABLE, ROWS + "0.1,-2\n", "wheel.csv:3: found wheel_m_s -2, expected m/s from 0 to 150; signed"),
    "absurd": (TABLE, ROWS + "0.1,400\n", "wheel.csv:3: found wheel_m_s 400, expected m/s from 0 to 150"),
    "signed and absurd": (TABLE + "signed = true\n", ROWS + "0.1,-400\n", "expected m/s from -150 to 150"),
    "time runs back": (TABLE, ROWS + "0.0,2\n", "wheel.csv:3: found t_s 0.000000 after 0.000000"),
    "another clock": (TABLE, "t_s,wheel_m_s\n900,1\n901,1\n", "and wheel from 900.000 to 901.000 s"),
    "no column": (TABLE, "t_s,speed\n0,1\n", "wheel.csv:1: found column 'speed'"),
    "none in the IMU's": ("[wheel]\n", None, "imu.csv:1: found no column wheel_m_s"),
    "no file": ('[wheel]\nfile = "w.csv"\n', None, "found 'w.csv', which does not exist"),
    "no direction": (TABLE + "forward = [1, 1, 0]\n", None, "a direction of length 1 in IMU axes"),
    "a sigma of nought": (TABLE + "wheel_std_m_s = 0\n", None, "wheel.wheel_std_m_s"),
    "unknown key": (TABLE + "scale = 1.0\n", None, "unknown key 'wheel.scale'"),
}


@pytest.mark.parametrize(("table", "rows", "said"), WRONG.values(), ids=WRONG)
def test_each_wrong_wheel_is_refused_in_one_line(table: str, rows: str | None, said: str, tmp_path: Path) -> None:
    folder = with_wheel(tmp_path / "log", table, rows)
    with pytest.raises(DataRefused) as refused:
        read_fusion(folder)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("factor", "unit"), [(3.6, "km/h"), (2.237, "mph"), (1000.0, "mm/s")])
def test_speeds_in_another_unit_are_known_by_gnss(factor: float, unit: str, tmp_path: Path) -> None:
    told = zip(TIMES.tolist(), (np.minimum(GNSS_SPEED * factor, 150)).tolist(), strict=True)
    rows = "t_s,wheel_m_s\n" + "".join(f"{t:.3f},{v:.4f}\n" for t, v in told)
    if factor == 1000.0:
        rows = rows.replace(",150.0000", ",149")
        unit = "m/s"  # beyond what a speed may be; which unit it was does not show
    with pytest.raises(DataRefused, match=f"times GNSS's speed.*{unit}"):
        read_fusion(with_wheel(tmp_path / "log", TABLE, rows))


def test_a_wheel_without_a_table_or_without_an_imu_is_refused(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "log")
    head, *rows = (folder / "imu.csv").read_text().splitlines()
    (folder / "imu.csv").write_text("\n".join([head + ",wheel_m_s", *(f"{row},1" for row in rows)]) + "\n")
    with pytest.raises(DataRefused, match=r"expected a table \[wheel\]"):
        read_fusion(folder)
    without = TOML[: TOML.index("[imu]")] + TOML[TOML.index("[gnss]") :] + TABLE
    (folder / "fusion.toml").write_text(without)
    with pytest.raises(DataRefused, match=r"\[imu\] beside \[wheel\]"):
        read_fusion(folder)
