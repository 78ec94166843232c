"""The factors of a fix with unknown lever arm and offset: as gtsam's own, with slopes as differences have."""

import numpy as np
import pytest

from procedures.fusion.inner.fix_factors import FixFactors

X, V, C = 1, 2, 3
STEP = 1e-6


@pytest.mark.parametrize("part", [0, 1], ids=["velocity", "position"])
def test_slopes_are_those_of_differences(part: int) -> None:
    gtsam = pytest.importorskip("gtsam", reason="gtsam is not installed: `make locate`")
    rng = np.random.default_rng(1)
    pose = gtsam.Pose3(gtsam.Rot3.Expmap(rng.normal(size=3)), rng.normal(size=3))
    v, c = rng.normal(size=3), rng.normal(size=4)
    says = FixFactors(rng.normal(size=3), np.ones(3), rng.normal(size=3), np.ones(3))
    factor = says.with_constants(gtsam, [X, V, C], rng.normal(size=3), rng.normal(size=3))[part]

    def off(dx: np.ndarray, dv: np.ndarray, dc: np.ndarray) -> np.ndarray:
        return np.asarray(factor.unwhitenedError(_values(gtsam, pose.retract(dx), v + dv, c + dc)))

    A, _ = factor.linearize(_values(gtsam, pose, v, c)).jacobian()
    zero = [np.zeros(6), np.zeros(3), np.zeros(4)]
    columns = []
    for which, part_of in enumerate(zero):
        for axis in range(len(part_of)):
            moved = [each.copy() for each in zero]
            moved[which][axis] = STEP
            columns.append((off(*moved) - off(*zero)) / STEP)
    assert np.allclose(A, np.array(columns).T, atol=1e-5)


def test_a_position_without_an_offset_is_gtsams_own() -> None:
    gtsam = pytest.importorskip("gtsam", reason="gtsam is not installed: `make locate`")
    rng = np.random.default_rng(2)
    pose = gtsam.Pose3(gtsam.Rot3.Expmap(rng.normal(size=3)), rng.normal(size=3))
    lever, p = rng.normal(size=3), rng.normal(size=3)
    says = FixFactors(None, np.ones(3), p, np.ones(3))
    (ours,) = says.with_constants(gtsam, [X, V, C], np.zeros(3), np.zeros(3))
    (theirs,) = says.as_given(gtsam, [X, V, C], np.zeros(3), lever)
    values = _values(gtsam, pose, rng.normal(size=3), np.r_[lever, 0.0])
    assert np.allclose(ours.unwhitenedError(values), theirs.unwhitenedError(values))


def _values(gtsam: object, pose: object, v: np.ndarray, c: np.ndarray) -> object:
    values = gtsam.Values()  # type: ignore[attr-defined]
    values.insert(X, pose)
    values.insert(V, v)
    values.insert(C, c)
    return values
