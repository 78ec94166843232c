"""What a fusion folder holds comes to memory as it stands in the files."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from station.errors import DataRefused
from station.files.fusion_folder import read_fusion
from station.files.fusion_folder.fusion_reading import refuse_apart, refuse_far, refuse_units
from tests.refusals import refused
from tests.station.files.fusion_folder.drive_folders import TOML, write_folder


def test_a_folder_is_read_as_it_was_written(tmp_path: Path) -> None:
    log = read_fusion(write_folder(tmp_path))
    assert log.imu is not None
    assert log.truth is not None
    assert log.odometry is not None
    assert len(log.fixes.t) == len(log.imu.t) == len(log.odometry) == 200
    assert np.abs(log.fixes.p_n - log.truth.p).max() < 0.2 * 5
    assert log.gravity == 9.8066
    assert set(log.fixes.position_std) == {0.2}


def test_what_a_receiver_does_not_give_is_nan_and_its_own_sigmas_win(tmp_path: Path) -> None:
    write_folder(tmp_path)
    rows = ["t_s,e_m,n_m,u_m,ve_m_s,vn_m_s,position_std_m", "0,1,2,3,4,5,", "1,1,2,3,,,2.5"]
    (tmp_path / "gnss.csv").write_text("\n".join(rows))
    fixes = read_fusion(tmp_path).fixes
    assert fixes.position_std.tolist() == [0.2, 2.5]
    assert np.isnan(fixes.v_n).tolist() == [[False, False, True], [True, True, True]]


FILE = Path("imu.csv")


def imu(force: float = 9.8, rate: float = 0.5, peak_force: float = 0.0, peak_rate: float = 0.0) -> ImuSeries:
    f, omega = (
        np.tile([0.6 * force, 0.0, -0.8 * force], (101, 1)),
        np.tile([0.0, 0.8 * rate, 0.6 * rate], (101, 1)),
    )
    f[50, 1] += peak_force
    omega[50, 0] += peak_rate
    return ImuSeries(np.arange(101.0), omega, f)


@pytest.mark.parametrize(
    ("given", "reported"),
    [
        (imu(4.1), ""), (imu(3.9), "3.9"), (imu(24.9), ""), (imu(25.1), "25"), (imu(0.51), "of g,"),
        (imu(1.99), "of g,"), (imu(501.0), "of mg,"), (imu(1999.0), "of mg,"), (imu(2001.0), "2001"),
        (imu(peak_force=4990.0), ""), (imu(peak_force=-5010.0), "5010"), (imu(rate=2.99), ""),
        (imu(rate=3.01), "deg/s"), (imu(rate=0.0, peak_rate=29.0), ""), (imu(rate=0.0, peak_rate=40.0), "40"),
    ],
)  # fmt: skip
def test_forces_and_rates_that_no_vehicle_has_are_of_another_unit(given: ImuSeries, reported: str) -> None:
    if not reported:
        refuse_units(given, FILE)
        return
    with refused(DataRefused, None, reported):
        refuse_units(given, FILE)


def fixes(t: list[float], p: float = 0.0) -> GnssFixes:
    n = len(t)
    place = np.zeros((n, 3))
    place[-1, 1] = p
    return GnssFixes(np.array(t), place, np.zeros((n, 3)), np.zeros(n), np.ones(n), np.ones(n))


def test_a_place_beyond_ten_thousand_kilometres_is_of_another_frame() -> None:
    refuse_far(fixes([0.0, 1.0], -0.99e7), FILE)
    with refused(DataRefused, None, "1.01e+07 m"):
        refuse_far(fixes([0.0, 1.0], -1.01e7), FILE)


@pytest.mark.parametrize(
    ("t", "overlaps"),
    [
        ([0.0, 5.1], True),
        ([0.0, 5.0], False),
        ([9.0, 12.0], False),
        ([8.9, 12.0], True),
        ([6.0, 7.0], True),
    ],
)
def test_clocks_that_do_not_meet_are_reported(t: list[float], overlaps: bool) -> None:
    moved = np.arange(5.0, 9.1)
    if overlaps:
        refuse_apart(fixes(t), moved, "IMU", FILE)
        return
    with refused(DataRefused, None, "5.000 to 9.000 s"):
        refuse_apart(fixes(t), moved, "IMU", FILE)


Breaking = Callable[[Path], object]


def _edit(name: str, old: str, new: str) -> Breaking:
    def breaking(folder: Path) -> None:
        text = (folder / name).read_text()
        assert old in text
        (folder / name).write_text(text.replace(old, new, 1))

    return breaking


def _scaled(name: str, columns: slice, factor: float) -> Breaking:
    def breaking(folder: Path) -> None:
        comma = " " if name.endswith(".tum") else ","
        header, *rows = (folder / name).read_text().splitlines()
        header, rows = ("", [header, *rows]) if comma == " " else (header, rows)
        cells = [row.split(comma) for row in rows]
        for row in cells:
            row[columns] = [f"{float(cell) * factor + (columns.start == 0) * 1000:.6f}" for cell in row[columns]]
        (folder / name).write_text("\n".join([header, *(comma.join(row) for row in cells)]) + "\n")

    return breaking


def _toml(old: str, new: str) -> Breaking:
    return _edit("fusion.toml", old, new)


def _one_bad_sigma(folder: Path) -> None:
    header, *rows = (folder / "gnss.csv").read_text().splitlines()
    rows = [f"{row},{0.2 * (number != 2):g}" for number, row in enumerate(rows)]
    (folder / "gnss.csv").write_text("\n".join([f"{header},position_std_m", *rows]) + "\n")


TRACKS = '[tracks]\nfile = "tracks.csv"\nstd_px = 1.0\n'
BAD_POSE = "fx_px = 1.0\nfy_px = 1.0\ncx_px = 1.0\ncy_px = 1.0\nimu_from_camera = [[1.0, 0.0, 0.0, 0.0], "
BAD_POSE += "[0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]\n"
REFUSED = {
    "time runs back": (_edit("gnss.csv", "0.200000000,", "0.050000000,"), "gnss.csv:4:"),
    "no overlap": (_scaled("gnss.csv", slice(0, 1), 1.0), "1000.000"),
    "deg/s": (_scaled("imu.csv", slice(1, 4), 57.3), "deg/s"),
    "Earth-centred": (_scaled("gnss.csv", slice(1, 4), 1e9), "gnss.csv"),
    "g": (_scaled("imu.csv", slice(4, 7), 0.102), "of g,"),
    "no quaternion": (
        lambda folder: (folder / "odometry.tum").write_text(
            "0 0 0 0 0 0 0 1\n9 0 0 0 0 0 0.7 0.7\n19 0 0 0 0 0 0 2"
        ),
        "odometry.tum:2:",
    ),
    "nan in TUM": (_edit("truth.tum", "0.100000000 ", "nan "), "truth.tum:2:"),
    "no intrinsics": (_toml("[truth]", TRACKS + "[truth]"), "fx_px"),
    "no rotation": (_toml("[truth]", TRACKS + BAD_POSE + "[truth]"), "imu_from_camera"),
    "no sigma": (_toml("position_std_m = 0.2\n", ""), "gnss.csv:2:"),
    "one sigma of nought": (_one_bad_sigma, "gnss.csv:4:"),
    "neither": (
        lambda folder: (folder / "fusion.toml").write_text(
            TOML[: TOML.index("[imu]")] + TOML[TOML.index("[gnss]") : TOML.index("[odometry]")]
        ),
        "[imu]",
    ),
    "unknown key": (_toml("lever_arm_m", "leaver_arm_m"), "'gnss.leaver_arm_m'"),
    "half a velocity": (_edit("gnss.csv", "vn_m_s,", "course_rad,"), "ve_m_s"),
    "a file outside": (_toml('"gnss.csv"', '"../gnss.csv"'), "../gnss.csv"),
}


@pytest.mark.parametrize(("breaking", "reported"), REFUSED.values(), ids=REFUSED)
def test_each_broken_folder_is_refused_in_one_line(breaking: Breaking, reported: str, tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "log")
    breaking(folder)
    with refused(DataRefused, None, reported):
        read_fusion(folder)
