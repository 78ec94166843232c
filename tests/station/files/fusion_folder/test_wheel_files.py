"""The wheel of a fusion folder: read from its own file or the IMU's, refused in one line where it is wrong."""

from pathlib import Path

import numpy as np
import pytest

from station.errors import DataRefused
from station.files.fusion_folder import read_fusion
from station.files.fusion_folder.fusion_reading import files_of
from tests.refusals import refused
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
    "nan": (TABLE, ROWS + "0.1,nan\n", "wheel.csv:3:"), "empty": (TABLE, ROWS + "0.1,\n", "wheel.csv:3:"),
    "backwards": (TABLE, ROWS + "0.1,-2\n", "signed"), "absurd": (TABLE, ROWS + "0.1,400\n", "400"),
    "time runs back": (TABLE, ROWS + "0.0,2\n", "wheel.csv:3:"),
    "another clock": (TABLE, "t_s,wheel_m_s\n900,1\n901,1\n", "900.000 to 901.000 s"),
    "no column": (TABLE, "t_s,speed\n0,1\n", "'speed'"), "none in the IMU's": ("[wheel]\n", None, "imu.csv:1:"),
    "no direction": (TABLE + "forward = [1, 1, 0]\n", None, "length 1"),
    "a sigma of zero": (TABLE + "wheel_std_m_s = 0\n", None, "wheel.wheel_std_m_s"),
    "unknown key": (TABLE + "scale = 1.0\n", None, "'wheel.scale'"),
}  # fmt: skip


@pytest.mark.parametrize(("table", "rows", "said"), WRONG.values(), ids=WRONG)
def test_each_wrong_wheel_is_refused(table: str, rows: str | None, said: str, tmp_path: Path) -> None:
    folder = with_wheel(tmp_path / "log", table, rows)
    with refused(DataRefused, None, said):
        read_fusion(folder)


def test_a_wheel_without_a_table_or_without_an_imu_is_refused(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "log")
    head, *rows = (folder / "imu.csv").read_text().splitlines()
    (folder / "imu.csv").write_text("\n".join([head + ",wheel_m_s", *(f"{row},1" for row in rows)]) + "\n")
    with refused(DataRefused, None, "[wheel]"):
        read_fusion(folder)
    without = TOML[: TOML.index("[imu]")] + TOML[TOML.index("[gnss]") :] + TABLE
    (folder / "fusion.toml").write_text(without)
    with refused(DataRefused, None, "[imu]"):
        read_fusion(folder)
