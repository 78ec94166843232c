"""An attitude log is read, or refused with its line: time, axes, units and ranges that cannot be."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from procedures.errors import ErrorCode
from station.attitude.attitude_log import read_log
from station.cli import run
from station.errors import DataRefused
from tests.refusals import refused

HEADER = "t_s,p_rad_s,q_rad_s,r_rad_s,fx_m_s2,fy_m_s2,fz_m_s2"
ROW = "0.001,0.002,-0.001,0.1,-0.2,-9.8"


def write(path: Path, rows: list[str], header: str = HEADER) -> Path:
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def rows(n: int = 50) -> list[str]:
    return [f"{i * 0.01:.2f},{ROW}" for i in range(n)]


def put(line: int, text: str) -> Callable[[list[str]], list[str]]:
    return lambda lines: [*lines[: line - 2], text, *lines[line - 1 :]]


@pytest.mark.parametrize(
    ("damage", "line", "reported"),
    [
        (put(7, f"nan,{ROW}"), 7, "t_s"), (put(7, "0.05,0.001,NaN,-0.001,0.1,-0.2,-9.8"), 7, "q_rad_s"),
        (put(7, "0.05,0.001,,-0.001,0.1,-0.2,-9.8"), 7, "q_rad_s"), (put(7, f"0.04,{ROW}"), 7, "0.04"),
        (put(7, f"0.01,{ROW}"), 7, "0.01"), (put(7, "0.05,0.001,120,-0.001,0.1,-0.2,-9.8"), 7, "deg/s"),
        (put(7, "0.05,0.001,0"), 7, ""), (lambda lines: lines[:1], 2, ""),
        (lambda lines: [f"{i}0,{ROW}" for i in range(50)], 3, "ms"),
    ],
)  # fmt: skip
def test_a_bad_row_is_refused_with_its_line(
    tmp_path: Path, damage: Callable[[list[str]], list[str]], line: int, reported: str
) -> None:
    with refused(DataRefused, None, reported, line=line):
        read_log(write(tmp_path / "log.csv", damage(rows())))


@pytest.mark.parametrize("missing", ["t_s", "q_rad_s", "fz_m_s2"])
def test_a_missing_column_is_refused(tmp_path: Path, missing: str) -> None:
    path = write(
        tmp_path / "log.csv", rows(), HEADER.replace(missing, "scored" if missing != "t_s" else "roll_rad")
    )
    with refused(DataRefused):
        read_log(path)


def test_half_a_velocity_and_a_score_of_2_are_refused(tmp_path: Path) -> None:
    with refused(DataRefused, None, "vn_m_s,vd_m_s"):
        read_log(write(tmp_path / "a.csv", [f"{r},1,2" for r in rows()], HEADER + ",vn_m_s,vd_m_s"))
    with refused(DataRefused, None, "scored", line=2):
        read_log(write(tmp_path / "b.csv", [f"{r},2" for r in rows()], HEADER + ",scored"))


def test_optional_cells_may_be_empty(tmp_path: Path) -> None:
    lines = [f"{r},{'' if i % 2 else 12.5},,," for i, r in enumerate(rows())]
    log = read_log(write(tmp_path / "log.csv", lines, HEADER + ",airspeed_m_s,vn_m_s,ve_m_s,vd_m_s"))
    assert log.airspeed is not None
    assert np.isnan(log.airspeed[1::2]).all()
    assert (log.airspeed[::2] == 12.5).all()
    assert log.velocity is not None
    assert np.isnan(log.velocity).all()


def test_axes_that_are_not_right_handed_exit_3_with_the_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    t = np.arange(0, 10, 0.01)
    roll = np.sin(t)
    table = np.stack([t, -np.cos(t), 0 * t, 0 * t, 0 * t, -9.8 * np.sin(roll), -9.8 * np.cos(roll)], axis=1)
    path = write(tmp_path / "log.csv", [",".join(f"{x:.7g}" for x in row) for row in table])
    assert run(["attitude", str(path)]) == 3
    assert "-p,q,r" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("columns", "largest", "beyond"),
    [
        ("roll_rad,pitch_rad", "6.283,-1.5708", "6.284,0"), ("roll_rad,pitch_rad", "0,1.5708", "0,-1.571"),
        ("heading_rad", "-12.566", "12.567"), ("airspeed_m_s", "3000", "3000.1"),
        ("vn_m_s,ve_m_s,vd_m_s", "9999,-9999,10000", "0,0,-10001"),
    ],
)  # fmt: skip
def test_a_column_is_taken_up_to_its_limit(tmp_path: Path, columns: str, largest: str, beyond: str) -> None:
    header = f"{HEADER},{columns}"
    assert len(read_log(write(tmp_path / "within.csv", [f"{row},{largest}" for row in rows()], header)).t) == 50
    with refused(DataRefused, line=2):
        read_log(write(tmp_path / "beyond.csv", [f"{row},{beyond}" for row in rows()], header))


@pytest.mark.parametrize(
    ("within", "beyond"),
    [("86.9,0,0,0,0,-9.8", "87.1,0,0,0,0,-9.8"), ("0,0,0,0,0,4999", "0,0,0,0,-5001,0")],
)
def test_a_sensor_is_taken_within_its_range(tmp_path: Path, within: str, beyond: str) -> None:
    """One row of 1000 that shows a range; the others rest."""
    rest = [f"{i / 100},{ROW}" for i in range(1000)]
    assert len(read_log(write(tmp_path / "within.csv", [*rest, f"10,{within}"])).t) == 1001
    with pytest.raises(DataRefused):
        read_log(write(tmp_path / "beyond.csv", [*rest, f"10,{beyond}"]))


def test_rows_are_from_ten_microseconds_to_a_second_apart(tmp_path: Path) -> None:
    for step, taken in (("1.0", True), ("1.01", False), ("1.1e-5", True), ("0.9e-5", False)):
        path = write(tmp_path / "log.csv", [f"{i * float(step):.9f},{ROW}" for i in range(20)])
        if taken:
            assert len(read_log(path).t) == 20
        else:
            with refused(DataRefused):
                read_log(path)


@pytest.mark.parametrize(
    ("force", "code"),
    [
        ("0,0,-1.0", ErrorCode.UNIT), ("0,0,-999", ErrorCode.UNIT), ("0,0,-980", ErrorCode.UNIT),
        ("0,0,0", ErrorCode.GRAVITY), ("0.02,0.3,-0.1", ErrorCode.GRAVITY), ("0,0,-4.9", ErrorCode.GRAVITY),
        ("0,0,-19.6", ErrorCode.GRAVITY), ("0,0,-10.5", None), ("5,5,-6.6", None),
    ],
)  # fmt: skip
def test_a_rest_without_the_length_of_gravity_is_refused(
    tmp_path: Path, force: str, code: ErrorCode | None
) -> None:
    path = write(tmp_path / "log.csv", [f"{i / 100},0.001,0.002,-0.001,{force}" for i in range(500)])
    if code is None:
        assert len(read_log(path).t) == 500
        return
    with refused(DataRefused, code):
        read_log(path)
