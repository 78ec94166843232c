"""A real car with positions alone: KITTI as it lies in gtsam's wheel, the first half minute of it."""

from importlib.util import find_spec
from pathlib import Path

import pytest

from station import cli
from station.files.fusion_folder import read_tum


def test_a_car_with_every_other_fix_is_where_the_others_say(tmp_path: Path) -> None:
    if find_spec("gtsam") is None:
        pytest.skip("the recording lies in gtsam's wheel: `pip install --no-deps gtsam`")
    from tests.benchmarks.kitti import held_out, write_kitti

    held = write_kitti(tmp_path / "log", every=2, seconds=33.0)
    assert cli.run(["locate", str(tmp_path / "log"), "--batch", str(tmp_path / "b.tum")]) == 0
    off = held_out(read_tum(tmp_path, "b.tum", 1), held)
    assert len(off) >= 15
    assert off.mean() < 0.15
