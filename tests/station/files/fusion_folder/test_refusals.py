"""Each way to break a fusion folder is refused with the file and its line, or the key that is wrong."""

from collections.abc import Callable
from pathlib import Path

import pytest

from station.errors import DataRefused
from station.files.fusion_folder import read_fusion
from tests.refusals import refused
from tests.station.files.fusion_folder.folders import TOML, write_folder

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


@pytest.mark.parametrize(("breaking", "said"), REFUSED.values(), ids=REFUSED)
def test_each_broken_folder_is_refused_in_one_line(breaking: Breaking, said: str, tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "log")
    breaking(folder)
    with refused(DataRefused, None, said):
        read_fusion(folder)
