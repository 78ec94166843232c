"""A wheel's speeds by themselves: which are refused, when another unit shows, and how they are written."""

from pathlib import Path

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import GnssFixes, WheelSpeeds
from station.errors import DataRefused
from station.files.fusion_folder import read_fusion
from station.files.fusion_folder.fusion_reading import files_of
from station.files.fusion_folder.fusion_schema import WheelTable
from station.files.fusion_folder.fusion_tables import read_wheel, refuse_unit
from station.files.tables.table import Table
from tests.refusals import refused
from tests.station.files.fusion_folder.drive_folders import TOML, write_folder

FILE = Path("wheel.csv")


def read(folder: Path, *speeds: float, signed: bool = False, file: str | None = None) -> WheelSpeeds:
    """Return what is read of a column of the IMU's file, whose first row is line 5."""
    columns = {"t_s": np.arange(len(speeds)) / 10, "wheel_m_s": np.array(speeds)}
    imu = Table(folder / "imu.csv", columns, lines=range(5, 1000))
    return read_wheel(folder, WheelTable(signed=signed, file=file), 12, imu)


@pytest.mark.parametrize("file", [None, "imu.csv"])
def test_cells_without_a_speed_are_left_out(file: str | None, tmp_path: Path) -> None:
    found = read(tmp_path, 0.0, np.nan, 2.0, np.nan, 150.0, file=file)
    assert found.t.tolist() == [0.0, 0.2, 0.4]
    assert found.speed.tolist() == [0.0, 2.0, 150.0]
    assert read(tmp_path, -150.0, 150.0, signed=True).speed.tolist() == [-150.0, 150.0]


@pytest.mark.parametrize(
    ("speeds", "signed", "line", "value"),
    [
        ((1.0, -0.5, 200.0), False, 6, "-0.5"), ((1.0, 2.0, 150.5, -1.0), False, 7, "150.5"),
        ((1.0, -150.5), True, 6, "-150.5"), ((np.nan, np.nan), False, None, "wheel_m_s"),
    ],
)  # fmt: skip
def test_the_first_cell_that_is_no_speed_is_refused_with_its_line(
    speeds: tuple[float, ...], line: int | None, value: str, tmp_path: Path, *, signed: bool
) -> None:
    with refused(DataRefused, None, value, line=line):
        read(tmp_path, *speeds, signed=signed)


def fixes(speeds: FloatArray, begin: float = 0.0) -> GnssFixes:
    """Return fixes a second apart that go south-east at speeds (n,) [m/s] and climb ten times as fast."""
    n = len(speeds)
    v = speeds[:, None] * np.array([0.6, -0.8, 10.0])
    nothing = np.full(n, np.nan)
    return GnssFixes((begin + np.arange(n)).astype(np.float64), np.zeros((n, 3)), v, nothing, nothing, nothing)


def wheel(speeds: FloatArray) -> WheelSpeeds:
    return WheelSpeeds(np.arange(len(speeds)).astype(np.float64), speeds)


def refusal(factor: float, gnss: FloatArray, begin: float = 0.0) -> str:
    """Return what is said of a wheel that tells GNSS's speed times a factor, empty where nothing is."""
    try:
        refuse_unit(wheel(factor * gnss), fixes(gnss, begin), FILE)
    except DataRefused as error:
        return str(error)
    return ""


GOING = np.linspace(3.0, 12.0, 40)


@pytest.mark.parametrize(
    ("factor", "guess"),
    [
        (3.6, "as of km/h"), (-3.6, "as of km/h"), (2.237, "as of mph"), (1.944, "as of knots"),
        (3.28, "as of ft/s"), (0.1, ""), (100.0, "as of cm/s"), (1000.0, "as of mm/s"),
        (85.0, "as of cm/s"), (118.0, "as of cm/s"),
        (82.0, ""), (122.0, ""), (0.59, ""), (1.61, ""),
    ],
)  # fmt: skip
def test_another_unit_is_named_where_it_is_near_enough(factor: float, guess: str) -> None:
    reported = refusal(factor, GOING)
    assert f"{abs(factor):.3g} times" in reported
    assert guess in reported
    assert ("as of" in reported) == ("as of" in guess)


@pytest.mark.parametrize(("count", "is_stated"), [(19, False), (20, True)])
def test_a_unit_shows_by_twenty_fixes_that_go(count: int, *, is_stated: bool) -> None:
    going = np.r_[np.full(count, 5.0), np.full(30, 1.9)]  # the rest are slower than two metres a second
    assert bool(refusal(3.6, going)) == is_stated
    assert bool(refusal(3.6, np.r_[np.full(count, 2.1), np.full(30, 2.0)])) == is_stated


TABLE = '[wheel]\nfile = "wheel.csv"\n'
TIMES = np.arange(0.0, 19.9, 0.05)
GNSS_SPEED = np.hypot(5 * 0.4 * np.cos(0.4 * TIMES), 3 * 0.8 * np.cos(0.8 * TIMES))


def with_wheel(folder: Path, table: str = TABLE, rows: str | None = None) -> Path:
    write_folder(folder)
    (folder / "fusion.toml").write_text(TOML + table)
    stated = zip(TIMES.tolist(), GNSS_SPEED.tolist(), strict=True)
    (folder / "wheel.csv").write_text(rows or "t_s,wheel_m_s\n" + "".join(f"{t:.3f},{v:.4f}\n" for t, v in stated))
    return folder


def test_a_wheel_of_its_own_file_is_read(tmp_path: Path) -> None:
    log = read_fusion(with_wheel(tmp_path / "log"))
    assert log.wheel is not None
    assert np.allclose(log.wheel.speed, GNSS_SPEED, atol=1e-4)
    assert (tmp_path / "log" / "wheel.csv") in files_of(tmp_path / "log")


def test_a_column_of_the_imu_is_read_where_its_cells_are_not_empty(tmp_path: Path) -> None:
    folder = with_wheel(tmp_path / "log", "[wheel]\nscale_std = 0.02\nforward = [0, 1, 0]\n")
    head, *rows = (folder / "imu.csv").read_text().splitlines()
    stated = [f"{row},{2 + i / 100 if i % 2 else ''}" for i, row in enumerate(rows[:200])]
    (folder / "imu.csv").write_text("\n".join([head + ",wheel_m_s", *stated]) + "\n")
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


@pytest.mark.parametrize(("table", "rows", "reported"), WRONG.values(), ids=WRONG)
def test_each_wrong_wheel_is_refused(table: str, rows: str | None, reported: str, tmp_path: Path) -> None:
    folder = with_wheel(tmp_path / "log", table, rows)
    with refused(DataRefused, None, reported):
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
