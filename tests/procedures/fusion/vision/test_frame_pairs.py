"""Which frames of a camera make a pair, and the points they share: tracks written down."""

from collections.abc import Callable

import numpy as np
import pytest

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


@pytest.mark.parametrize(("gap", "pairs"), [(0.35, 1), (0.64, 1), (0.66, 0)])
def test_of_a_slow_camera_the_next_frame_is_taken(gap: float, pairs: int) -> None:
    assert len(frame_pairs(tracks([0.0, gap], seen_all(50)), CAMERA)) == pairs


@pytest.mark.parametrize(("spacing", "t1"), [(0.344, 0.344), (0.346, 0.346), (0.172, 0.344), (0.174, 0.174)])
def test_the_partner_may_be_half_a_frame_later(spacing: float, t1: float) -> None:
    found = frame_pairs(tracks([0.0, spacing, 2 * spacing], seen_all(50)), CAMERA)
    assert found.t1[0] == pytest.approx(t1)


@pytest.mark.parametrize(("spacing", "kept"), [(0.0895, 2), (0.0905, 1)])
def test_frames_that_are_used_are_nine_hundredths_apart(spacing: float, kept: int) -> None:
    found = frame_pairs(tracks([0.0, spacing, 2 * spacing], seen_all(50)), CAMERA)
    assert found.t1[0] == pytest.approx(2 * spacing)
    assert len(found) == (1 if kept == 2 else 2)


@pytest.mark.parametrize(("shared", "t1"), [(40, 0.2), (39, 0.1), (20, 0.1), (19, None)])
def test_where_too_few_are_shared_a_nearer_frame_is_the_partner(shared: int, t1: float | None) -> None:
    times = [0.0, 0.1, 0.2]
    found = frame_pairs(tracks(times, lambda i: range(60 - shared, 120) if i else range(60)), CAMERA)
    first = found.t1[found.t0 == 0.0]
    assert first.tolist() == ([] if t1 is None else [t1])


def test_at_most_120_points_are_used_and_a_part_may_have_fewer() -> None:
    found = frame_pairs(tracks([0.0, 0.3, 0.6], lambda i: range(30 * (i == 2), 150)), CAMERA)
    assert found.there.sum(axis=1).tolist() == [120.0, 120.0]
    shorter = frame_pairs(tracks([0.0, 0.3, 0.6], lambda i: range(60 * (i == 2), 100)), CAMERA)
    assert shorter.there.sum(axis=1).tolist() == [100.0, 40.0]
    assert not shorter.there[1, 40:].any()
    part = found.part(np.array([1]), most=7)
    assert (part.t0.tolist(), part.t1.tolist(), part.y0.shape) == ([0.3], [0.6], (1, 7, 3))
    np.testing.assert_array_equal(part.y1, found.y1[1:, :7])
    assert found.part(slice(0, 1)).there.shape == (1, 120)


def test_without_frames_there_are_no_pairs() -> None:
    nothing = FeatureTracks(np.zeros(0), np.zeros(0, np.int64), np.zeros((0, 2)))
    assert len(frame_pairs(nothing, CAMERA)) == 0
