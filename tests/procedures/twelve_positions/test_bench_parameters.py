from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

from procedures.arrays import FloatArray
from procedures.campaign.campaign import FaceCertificate, Fixture
from procedures.frames import AXES
from procedures.positions import FACES, C_bn, face_of
from procedures.twelve_positions.bench_parameters import (
    FACE_TILT_RANGE_RAD,
    SLAB_TILT_RANGE_RAD,
    BenchParameters,
    Placement,
    skew_jacobian,
)
from tests.procedures.independent import body_from_level, campaign

QUARTER = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])


def certificate(sigma: float, tilt: FloatArray | None = None) -> FaceCertificate:
    return FaceCertificate(np.zeros(2) if tilt is None else tilt, sigma**2 * np.eye(2))


def two_campaigns() -> BenchParameters:
    first = campaign(fixture=Fixture(id="A"))
    second = campaign(fixture=Fixture(id="B"), latitude=-0.2, gravity_std=1e-4)
    at = [Placement(n % 2, n % 2, 1 + n % 12, 1e-3) for n in range(24)]
    return BenchParameters(tuple(at), (first, second), 2)


@settings(max_examples=30)
@given(st.integers(0, 10**6))
def test_all_placements_at_once_see_what_frames_says_one_by_one(seed: int) -> None:
    rng, bench = np.random.default_rng(seed), two_campaigns()
    x = 1e-2 * rng.standard_normal(bench.size)
    x[bench.shared :] *= 50
    vectors = [rng.standard_normal(3) for _ in range(2)]
    seen = bench.seen(x, vectors)
    for i, at in enumerate(bench.placements):
        pair = AXES.index(face_of(at.position)[0])
        sign = 1 if face_of(at.position).endswith("up") else -1
        tilt = bench.parallelism(x, at.cube)[pair] / 2 + sign * bench.perpendicularity(x, at.cube)[pair]
        C = C_bn(at.position, bench.slab(x, at.campaign), tilt, x[bench.heading_index(i)])
        assert seen[i] == pytest.approx(C @ vectors[at.campaign], abs=1e-13)


def test_campaigns_at_one_site_share_its_gravity() -> None:
    same = campaign(fixture=Fixture(id="A"))
    bench = BenchParameters((Placement(0, 0, 1, 1e-3), Placement(1, 0, 1, 1e-3)), (same, replace(same)), 1)
    assert len(bench.sites) == 1
    assert bench.size == 4 + 1 + 12 + 2


def prior_sigma(bench: BenchParameters) -> FloatArray:
    matrix = bench.priors().matrix
    sigma: FloatArray = np.sqrt(np.diag(np.linalg.pinv(matrix) @ np.linalg.pinv(matrix).T))
    return sigma


def test_priors_are_the_stated_and_plausible_sizes() -> None:
    sigma = prior_sigma(two_campaigns())
    assert sigma[:4] == pytest.approx(SLAB_TILT_RANGE_RAD)
    assert sigma[4:6] == pytest.approx([1e-9 / 9.80665, 1e-4 / 9.80665])
    assert sigma[6:12] == pytest.approx(FACE_TILT_RANGE_RAD * np.sqrt(2), rel=1e-6)
    assert sigma[-24:] == pytest.approx(1e-3)
    assert sigma[24:30] == pytest.approx(FACE_TILT_RANGE_RAD)  # the second cube's perpendicularity is free


def test_without_a_certificate_perpendicularity_is_held_where_the_items_put_it() -> None:
    """P1 table 2: X up is reached by one item, X down by three; Y and Z up by three, down by five."""
    bench = BenchParameters((Placement(0, 0, 1, 1e-3),), (campaign(),), 1)
    prior = bench.priors()
    mean, matrix = prior.mean, prior.matrix
    assert bench.held_pairs(0) == [True, True, True]
    assert np.all(mean == 0)
    p = np.arange(1.0, 7) * 1e-4
    x = np.zeros(bench.size)
    x[3:9] = p
    x[9:15] = p * np.repeat([1 / 4 - 1 / 2, 3 / 8 - 1 / 2, 3 / 8 - 1 / 2], 2)
    held = np.abs(matrix @ x)
    assert np.sum(held**2) == pytest.approx(np.sum((p / FACE_TILT_RANGE_RAD) ** 2) / 2, rel=1e-3)


def test_a_certificate_holds_the_tilt_of_its_face() -> None:
    tilt, sigma = np.array([3e-5, -2e-5]), 5e-6
    faces = {face: certificate(sigma, (i + 1) * tilt) for i, face in enumerate(FACES)}
    bench = BenchParameters((Placement(0, 0, 1, 1e-3),), (campaign(fixture=Fixture(faces)),), 1)
    assert bench.held_pairs(0) == [False, False, False]
    prior = bench.priors()
    mean, matrix = prior.mean, prior.matrix
    x, *_ = np.linalg.lstsq(matrix, mean, rcond=None)
    for pair in range(3):
        for sign, k in ((1, 0), (-1, 1)):
            found = bench.parallelism(x)[pair] / 2 + sign * bench.perpendicularity(x)[pair]
            pull = 2 * (sigma / FACE_TILT_RANGE_RAD) ** 2  # of the wide prior next to it, relative
            assert found == pytest.approx((2 * pair + k + 1) * tilt, rel=4 * pull)
    assert prior_sigma(bench)[3:9] == pytest.approx(np.sqrt(2) * sigma, rel=1e-4)
    assert prior_sigma(bench)[9:15] == pytest.approx(sigma / np.sqrt(2), rel=1e-4)


def test_an_imu_that_sat_in_the_cube_in_two_ways_sees_its_perpendicularity() -> None:
    turned = campaign(fixture=Fixture(C_sb=QUARTER, id="A"))
    bench = BenchParameters(
        (Placement(0, 0, 1, 1e-3), Placement(1, 0, 1, 1e-3)), (campaign(fixture=Fixture(id="A")), turned), 1
    )
    assert bench.held_pairs(0) == [False, False, False]


def ups(p: FloatArray, q: FloatArray) -> FloatArray:
    """Up vectors (12, 3) of a cube, of unit length exactly."""
    rows = []
    for position in range(1, 13):
        up = body_from_level(position)[:, 2].copy()
        pair = int(np.argmax(np.abs(up)))
        others = [i for i in range(3) if i != pair]
        up[others] = p[pair] / 2 + up[pair] * q[pair]
        up[pair] *= np.sqrt(1 - up[others] @ up[others])
        rows.append(up)
    return np.array(rows)


@pytest.mark.parametrize("seed", range(2))
def test_a_skew_that_is_held_at_zero_shifts_bias_and_scale_as_the_jacobian_says(seed: int) -> None:
    """By brute force: outputs of a skew cube, fitted with one that is not. Tilts 30 times real ones."""
    rng = np.random.default_rng(seed)
    p, q = 1e-3 * rng.standard_normal((2, 3, 2))
    E = np.eye(3) + 2e-2 * rng.standard_normal((3, 3))
    E /= np.linalg.norm(E, axis=1)[:, None]
    outputs = ups(p, q) @ E.T

    def residual(x: FloatArray) -> FloatArray:
        difference: FloatArray = (
            ups(x[12:].reshape(3, 2), np.zeros((3, 2))) @ x[:9].reshape(3, 3).T + x[9:12] - outputs
        )
        return difference.ravel()

    start = np.concatenate((E.ravel(), np.zeros(3), p.ravel()))
    x = least_squares(residual, start, xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    assert np.abs(residual(x)).max() < 1e-8  # the skew is invisible but for its second order
    k = np.linalg.norm(x[:9].reshape(3, 3), axis=1)
    S = np.array([q[0, 0] + q[1, 0], q[0, 1] + q[2, 0], q[1, 1] + q[2, 1]])
    scale, bias = skew_jacobian(p, E)
    size = 1e-6  # of p S and of q^2
    assert np.abs(x[9:12] / k - bias @ S).max() < 0.1 * size  # E, as large as this, turns the shift by 2 %
    assert np.abs(k - 1 - scale @ S).max() < 8 * size  # the squares of q themselves; scale @ S is 20 times that
    assert np.abs(scale @ S).max() > 8 * size
