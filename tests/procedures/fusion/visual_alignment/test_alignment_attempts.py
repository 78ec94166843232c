"""When an alignment by camera is tried: from a second after IMU, camera and GNSS all speak, until one ends."""

from typing import cast

import numpy as np
import pytest

from procedures.fusion.alignment.alignment_result import Waiting
from procedures.fusion.fusion_records import GnssFixes, ImuSeries
from procedures.fusion.vision.feature_tracks import FeatureTracks
from procedures.fusion.visual_alignment.visual_alignment_attempts import VisualAligner, align_by_camera


class NeverAligned:
    """Has the times at which it was asked."""

    def __init__(self) -> None:
        self.asked = list[float]()

    def align(self, imu: ImuSeries, tracks: FeatureTracks, fixes: GnssFixes, now: float) -> Waiting:
        self.asked.append(now)
        return Waiting(f"nothing at {now}")


def overlapping(first: dict[str, float], last: dict[str, float]) -> tuple[ImuSeries, FeatureTracks, GnssFixes]:
    t = {name: np.linspace(first[name], last[name], 5) for name in ("imu", "tracks", "fixes")}
    v = np.zeros((5, 3))
    return (
        ImuSeries(t["imu"], v, v),
        FeatureTracks(t["tracks"], np.arange(5), v[:, :2]),
        GnssFixes(t["fixes"], v, v, v[:, 0], v[:, 0], v[:, 0]),
    )


@pytest.mark.parametrize("late", ["imu", "tracks", "fixes"])
def test_the_first_attempt_is_a_second_after_the_last_of_them_begins(late: str) -> None:
    first, last = (
        {"imu": 0.0, "tracks": 0.0, "fixes": 0.0, late: 3.0},
        dict.fromkeys(("imu", "tracks", "fixes"), 10.0),
    )
    aligner = NeverAligned()
    found = align_by_camera(cast(VisualAligner, aligner), *overlapping(first, last))
    assert aligner.asked[0] == 4.0
    assert isinstance(found, Waiting)
    assert found.why == f"nothing at {aligner.asked[-1]}"


@pytest.mark.parametrize("early", ["imu", "tracks", "fixes"])
def test_no_attempt_is_made_after_the_first_of_them_ends(early: str) -> None:
    first, last = (
        dict.fromkeys(("imu", "tracks", "fixes"), 0.0),
        {"imu": 10.0, "tracks": 10.0, "fixes": 10.0, early: 4.1},
    )
    aligner = NeverAligned()
    align_by_camera(cast(VisualAligner, aligner), *overlapping(first, last))
    assert 3.0 < aligner.asked[-1] <= 4.1
    last[early] = 0.9
    assert "overlap" in cast(Waiting, align_by_camera(cast(VisualAligner, aligner), *overlapping(first, last))).why
