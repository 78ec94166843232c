"""The short forms of tests/benchmarks/replug.py and frozen_screen.py."""

from pathlib import Path

from tests.benchmarks.frozen_screen import FROZEN_S, freeze
from tests.benchmarks.replug import ASKED_S, replug
from tests.patience import paced


def test_a_replugged_device_is_back_within_3_s_and_nothing_reaches_over_the_gap(tmp_path: Path) -> None:
    got = replug(3, 1, tmp_path, away_s=(0.05, 0.3))
    assert max(got.back) <= ASKED_S, got
    assert got.marks == [False, True] * 3
    assert (got.blocks_over_a_gap, got.runs_over_a_gap) == (0, 0)
    assert got.blocks > 3


def test_a_station_frozen_under_a_device_of_1_khz_misses_no_frame(tmp_path: Path) -> None:
    speed = paced(5.0)
    got = freeze(tmp_path / "recording.mcap", speed)
    assert (got.station.missing, got.recording.missing) == (0, 0), got
    assert got.blind_s > 0.9 * FROZEN_S / speed
    assert min(got.station.samples, got.recording.samples) >= 5000
