"""A wheel's speeds by themselves: which are refused, when another unit shows, and how they are written."""

from pathlib import Path

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import GnssFixes
from procedures.fusion.wheel_speeds import WheelSpeeds
from station.errors import DataRefused
from station.files.columns import DataFile
from station.files.fusion_folder.fusion_schema import WheelTable
from station.files.fusion_folder.wheel import read_wheel, refuse_unit
from tests.refusals import refused

FILE = Path("wheel.csv")


def read(folder: Path, *speeds: float, signed: bool = False, file: str | None = None) -> WheelSpeeds:
    """Return what is read of a column of the IMU's file, whose first row is line 5."""
    columns = {"t_s": np.arange(len(speeds)) / 10, "wheel_m_s": np.array(speeds)}
    imu = DataFile(str(folder / "imu.csv"), columns, 5, "")
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
    said = refusal(factor, GOING)
    assert f"{abs(factor):.3g} times" in said
    assert guess in said
    assert ("as of" in said) == ("as of" in guess)


@pytest.mark.parametrize(("count", "is_told"), [(19, False), (20, True)])
def test_a_unit_shows_by_twenty_fixes_that_go(count: int, *, is_told: bool) -> None:
    going = np.r_[np.full(count, 5.0), np.full(30, 1.9)]  # the rest are slower than two metres a second
    assert bool(refusal(3.6, going)) == is_told
    assert bool(refusal(3.6, np.r_[np.full(count, 2.1), np.full(30, 2.0)])) == is_told
