"""What a fusion folder holds comes to memory as it stands in the files."""

from pathlib import Path

import numpy as np

from station.files.fusion_folder import read_fusion
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
