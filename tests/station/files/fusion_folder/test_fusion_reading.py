"""What a fusion folder holds comes to memory as it stands in the files."""

from pathlib import Path

import numpy as np

from procedures.fusion.fusion_records import Trajectory
from station.files.fusion_folder import read_fusion, read_tum, write_tum
from tests.station.files.fusion_folder.folders import write_folder


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


def test_a_written_trajectory_reads_back_past_comments(tmp_path: Path) -> None:
    written = Trajectory(
        np.array([0.5, 1.5]), np.array([[1.0, 2, 3], [4, 5, 6]]), np.array([[0, 0, 0, 1.0], [0, 0.6, 0, 0.8]])
    )
    write_tum(tmp_path / "a.tum", written)
    (tmp_path / "b.tum").write_text("# made by hand\n\n" + (tmp_path / "a.tum").read_text())
    read = read_tum(tmp_path, "b.tum", 1)
    assert np.abs(np.c_[read.t - written.t, read.p - written.p, read.q - written.q]).max() < 1e-6
