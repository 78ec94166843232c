"""Features are followed through rendered images within a pixel; what moves by itself is left out."""

import sys
from collections.abc import Iterator

import numpy as np
import pytest

from procedures.errors import ErrorCode
from procedures.fusion.vision.feature_tracker import (
    AnchoredPatches,
    FeatureTracker,
    FeatureTrackerSettings,
    FittedPatches,
    LensModel,
)
from procedures.optional_libraries import ExtraMissing
from tests.procedures.fusion.rendered import FOCAL, HEIGHT, WIDTH, Scene, frames
from tests.refusals import refused

LENS = LensModel(FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2, np.zeros(4))
SETTINGS = FeatureTrackerSettings(features=90, apart=12.0)


@pytest.fixture
def scene() -> Scene:
    return Scene(pytest.importorskip("cv2", reason="opencv is not installed"))


def followed(scene: Scene) -> Iterator[tuple[float, np.ndarray, np.ndarray]]:
    follower = FeatureTracker(LENS, SETTINGS)
    for t, image in frames(scene):
        yield t, *follower.follow(image)


def offsets(scene: Scene) -> tuple[np.ndarray, list[int]]:
    """Return how far each point is from where its first sight has it, and how many went on at each step."""
    first, off, kept = dict[int, tuple[float, np.ndarray]](), list[np.ndarray](), list[int]()
    for t, feature, uv in followed(scene):
        old = [i for i, number in enumerate(feature.tolist()) if number in first]
        kept.append(len(old))
        for i in old:
            t0, uv0 = first[int(feature[i])]
            if not scene.on_patch(t0, uv0[None])[0]:
                off.append(uv[i] - scene.seen_again(t0, uv0[None], t)[0])
        first |= {int(number): (t, uv[i]) for i, number in enumerate(feature) if int(number) not in first}
    rows = np.array(off)
    return np.linalg.norm(rows[np.isfinite(rows).all(axis=1)], axis=1), kept[1:]


def test_tracks_stay_within_a_pixel_of_the_truth(scene: Scene) -> None:
    off, kept = offsets(scene)
    assert len(off) > 400
    assert np.median(off) < 0.3
    assert np.mean(off < 1.0) > 0.98
    assert min(kept) > 40


def lives(scene: Scene, settings: FeatureTrackerSettings) -> tuple[float, float]:
    """Return which share of the features on the patch, and of the others, was followed for three steps or more."""
    first, steps, follower = dict[int, bool](), dict[int, int](), FeatureTracker(LENS, settings)
    for t, image in frames(scene):
        feature, uv = follower.follow(image)
        inside, around = scene.on_patch(t, uv, margin=-6.0), scene.on_patch(t, uv)
        for i, number in enumerate(feature.tolist()):
            if t < 0.6 and inside[i] == around[i]:
                first.setdefault(number, bool(inside[i]))
            steps[number] = steps.get(number, -1) + 1
    shares = [[steps[n] >= 3 for n, on_patch in first.items() if on_patch == which] for which in (True, False)]
    assert min(len(share) for share in shares) > 8
    return float(np.mean(shares[0])), float(np.mean(shares[1]))


def test_what_moves_by_itself_is_not_followed(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    scene.patch = True
    on_patch, others = lives(scene, SETTINGS)
    assert on_patch < 0.1
    assert others > 0.5
    off, _ = offsets(scene)
    assert np.mean(off < 1.0) > 0.95
    monkeypatch.setattr(FeatureTracker, "_one_motion", lambda _self, before, _after: np.ones(len(before), bool))
    allowed, _ = lives(scene, SETTINGS)
    assert allowed > 0.2  # what is not at rest on the patch's edge looks as it did
    monkeypatch.setattr(AnchoredPatches, "fit", unfitted)
    allowed, _ = lives(scene, SETTINGS)
    assert allowed > 0.6  # the tracker alone would have gone along


def unfitted(_self: AnchoredPatches, _image: np.ndarray, uv: np.ndarray) -> FittedPatches:
    """Return what the tracker says, as if all looked as it did."""
    one = np.ones(len(uv), np.float32)
    return FittedPatches(uv, np.tile(np.eye(2, dtype=np.float32), (len(uv), 1, 1)), one, 0 * one)


def test_an_empty_image_has_no_features_and_another_size_is_refused(scene: Scene) -> None:
    follower = FeatureTracker(LENS, SETTINGS)
    feature, uv = follower.follow(np.full((HEIGHT, WIDTH), 127, np.uint8))
    assert len(feature) == len(uv) == 0
    with refused(ValueError, None, str(WIDTH)):
        follower.follow(np.zeros((HEIGHT, WIDTH + 1), np.uint8))


def test_a_lens_is_straightened(scene: Scene) -> None:
    """The inverse of the distortion, had by hand: radial k1, k2 and tangential p1, p2."""
    k1, k2, p1, p2 = -0.28, 0.07, 0.0002, 2e-5
    x, y = np.array([0.3, -0.4, 0.0]), np.array([0.2, 0.25, 0.0])
    r2 = x**2 + y**2
    radial = 1 + k1 * r2 + k2 * r2**2
    bent = np.column_stack((
        x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x**2), y * radial + p1 * (r2 + 2 * y**2) + 2 * p2 * x * y
    ))  # fmt: skip
    lens = LensModel(FOCAL, FOCAL, WIDTH / 2, HEIGHT / 2, np.array([k1, k2, p1, p2]))
    straight = lens.straightened(FOCAL * bent + [WIDTH / 2, HEIGHT / 2])
    assert np.abs(straight - (FOCAL * np.column_stack((x, y)) + [WIDTH / 2, HEIGHT / 2])).max() < 0.05


def test_without_the_extra_it_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    with refused(ExtraMissing, ErrorCode.EXTRA_MISSING, extra="camera"):
        FeatureTracker(LENS)
