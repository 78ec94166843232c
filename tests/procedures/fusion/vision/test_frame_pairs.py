"""Which frames of a camera make a pair, and the points they share: tracks written down."""

from collections.abc import Callable

import numpy as np

from procedures.fusion.vision.feature_tracks import FeatureTracks, PinholeCamera
from procedures.fusion.vision.frame_pairs import frame_pairs

CAMERA = PinholeCamera(200.0, 100.0, 320.0, 240.0, 1.0, np.eye(3), np.zeros(3))


def tracks(times: list[float], features: Callable[[int], range]) -> FeatureTracks:
    """Return frames at ``times``; feature f stands at (f, i) px in frame i."""
    rows = [(t, f, i) for i, t in enumerate(times) for f in features(i)]
    t, feature, frame = (np.array(column) for column in zip(*rows, strict=True))
    return FeatureTracks(t, feature, np.stack((feature, frame), axis=1).astype(float))


def seen_all(n: int) -> Callable[[int], range]:
    return lambda _: range(n)


def test_a_pair_is_three_tenths_of_a_second_apart_and_frames_a_tenth() -> None:
    times = [0.05 * i for i in range(15)]  # used: 0, 0.1, 0.2 ... 0.7
    found = frame_pairs(tracks(times, seen_all(50)), CAMERA)
    np.testing.assert_allclose(found.t0, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    np.testing.assert_allclose(found.t1, [0.3, 0.4, 0.5, 0.6, 0.7, 0.7, 0.7])
    assert found.there.shape == (7, 50)
    assert found.there.all()


def test_points_are_on_the_plane_at_depth_one_and_of_the_same_feature() -> None:
    found = frame_pairs(tracks([0.0, 0.3], lambda i: range(10 * i, 45)), CAMERA)
    assert (found.y0[..., 2] == 1.0).all()
    np.testing.assert_allclose(found.y0[0, :, 0], found.y1[0, :, 0])
    features = np.rint(found.y0[0, :, 0] * 200.0 + 320.0).astype(int)
    assert sorted(features.tolist()) == list(range(10, 45))
    np.testing.assert_allclose(found.y0[0, :, 1], -2.4)
    np.testing.assert_allclose(found.y1[0, :, 1], -2.39)  # row 1 of 100 px
    assert len(found) == 1
