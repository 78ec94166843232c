from dataclasses import replace

import numpy as np
import pytest

from procedures.calibration.joint_calibration import solve
from procedures.calibration.residuals import fit_quality
from procedures.calibration.triad_calibration import triad_vector
from procedures.campaign.campaign import Campaign, Fixture, RestRecord, Site
from procedures.campaign.observations import TriadRests
from procedures.counts.sample_records import RateSeries
from procedures.free_positions.free_attitude_fit import solve_with_rests
from procedures.positions import FACES, face_normal
from procedures.twelve_positions.accelerometer_fit import TriadFit
from tests.procedures.free_units import NO_SERIES, Unit, at_rest, unit, ups
from tests.procedures.independent import campaign, dwells, specific_force

SIGMA = 1e-4  # count/s: 1e-7 g
EVERY = range(1, 13)


def errors(joint: TriadFit | None, true: Unit) -> np.ndarray:
    """k (3), E (9), D (3): error over its own sigma, 0 where the convention holds it."""
    assert joint is not None
    vector = triad_vector(joint, "accelerometer", joint)
    std = np.sqrt(np.diag(vector.covariance))
    off = vector.value - np.concatenate((true.k, true.E.ravel(), true.D))
    return np.where(std > 3e-9, off / np.maximum(std, 1e-300), 0.0)


def cube_and_free(seed: int, free: int, quadratic: float = 5e-5) -> tuple[Campaign, Unit, np.ndarray, np.ndarray]:
    """Rates of a unit with K2 on a tilted cube, and of free rests."""
    rng = np.random.default_rng(seed)
    true = unit(rng, 1000.0, 2e-3, quadratic=quadratic)
    faces, slab = 5e-5 * rng.standard_normal((6, 2)), 5e-5 * rng.standard_normal(2)
    u = specific_force(faces, slab, 1e-3 * rng.standard_normal(12), tuple(EVERY))
    rate, loose = true.output(u), true.output(ups(rng, free))
    rate += SIGMA * rng.standard_normal(rate.shape)
    loose += SIGMA * rng.standard_normal(loose.shape)
    return campaign(), true, rate, loose


@pytest.mark.parametrize("seed", range(2))
def test_rests_alone_give_the_truth_within_its_own_sigma(seed: int) -> None:
    rng = np.random.default_rng(seed)
    true = unit(rng, 1000.0, 2e-3, lower=True)
    rate = true.output(ups(rng, 30)) + SIGMA * rng.standard_normal((30, 3))
    joint = solve_with_rests([campaign()], None, at_rest(rate, SIGMA))
    assert joint is not None
    assert joint.is_turned_freely
    assert joint.dof == 30 - 9
    assert np.max(np.abs(errors(joint, true))) < 4.5


def test_the_sigmas_of_rests_alone_are_honest() -> None:
    found = []
    for seed in range(60):
        rng = np.random.default_rng(1000 + seed)
        true = unit(rng, 1000.0, 2e-3, lower=True)
        rate = true.output(ups(rng, 24)) + SIGMA * rng.standard_normal((24, 3))
        z = errors(solve_with_rests([campaign()], None, at_rest(rate, SIGMA)), true)
        found.append(z[[0, 1, 2, 6, 9, 10, 12, 13, 14]])
    rms = np.sqrt(np.mean(np.square(found)))
    assert 0.85 < rms < 1.15  # 540 numbers; the scatter found is never below zero, which widens a little


def test_scatter_beyond_noise_widens_the_sigmas_and_shows_in_the_global_test() -> None:
    rng = np.random.default_rng(5)
    true = unit(rng, 1000.0, 2e-3, lower=True)
    rate = true.output(ups(rng, 40)) + 10 * SIGMA * rng.standard_normal((40, 3))
    joint = solve_with_rests([campaign()], None, at_rest(rate, SIGMA))
    assert joint is not None
    assert joint.rests is not None
    assert joint.rests.excess == pytest.approx(1e-6, rel=0.4)
    assert np.max(np.abs(errors(joint, true))) < 4.5
    assert fit_quality(joint, None).p_value < 1e-6


@pytest.mark.parametrize("seed", range(2))
def test_free_positions_separate_k2_from_parallelism(seed: int) -> None:
    site, true, rate, loose = cube_and_free(seed, 12)
    joint = solve_with_rests([site], dwells(rate, SIGMA), at_rest(loose, SIGMA), quadratic=True)
    assert joint is not None
    assert joint.K2 is not None
    std = np.sqrt(np.diag(joint.fit.covariance)[-3:])
    assert np.all(std < 1e-6)
    assert np.all(np.abs(joint.K2 - true.K2) < 4.5 * std)
    z = errors(joint, true)
    assert np.max(np.abs(z[[0, 1, 2, 12, 13, 14]])) < 4.5
    assert fit_quality(joint, None).p_value > 1e-4


@pytest.mark.parametrize("seed", range(2))
def test_free_positions_show_the_misalignment_but_for_how_the_cube_is_turned(seed: int) -> None:
    site, true, rate, loose = cube_and_free(seed, 12, quadratic=0.0)
    joint = solve_with_rests([site], dwells(rate, SIGMA), at_rest(loose, SIGMA))
    assert joint is not None
    vector = triad_vector(joint, "accelerometer", joint)
    K = vector.value[:3, None] * vector.value[3:12].reshape(3, 3)
    turn = np.linalg.solve(true.k[:, None] * true.E, K)  # a rotation, if K is the truth in a turned frame
    assert np.abs(turn.T @ turn - np.eye(3)).max() < 2e-6  # tens of sigma; the faces are off by 1e-4
    assert np.abs(turn - np.eye(3)).max() > 1e-6


def on_faces(seed: int, slab: float) -> tuple[TriadRests, Unit]:
    """Six faces, each at a heading of its own on a leaning slab."""
    rng = np.random.default_rng(seed)
    true = unit(rng, 1000.0, 2e-3)
    up = np.array([face_normal(face) for face in FACES])
    tilt = slab * rng.standard_normal((6, 3)) * (up == 0)
    u = up * np.sqrt(1 - np.sum(tilt**2, axis=1))[:, None] + tilt
    rate = true.output(u) + SIGMA * rng.standard_normal((6, 3))
    rests = at_rest(rate, SIGMA)
    return replace(rests, rests=tuple((0, RestRecord(f, f, NO_SERIES)) for f in FACES)), true


@pytest.mark.parametrize("seed", range(2))
def test_six_faces_without_heading_give_the_truth_as_far_as_a_slab_may_be_tilted(seed: int) -> None:
    rests, true = on_faces(seed, 5e-3)
    joint = solve_with_rests([campaign()], None, rests)
    assert joint is not None
    assert not joint.is_turned_freely
    assert np.max(np.abs(errors(joint, true))) < 4.5
    vector = triad_vector(joint, "accelerometer", joint)
    assert 1e-3 < np.sqrt(vector.covariance[4, 4]) < 1e-2  # E_xy


def test_few_rests_or_rests_in_one_plane_determine_nothing() -> None:
    rng = np.random.default_rng(7)
    true = unit(rng, 1000.0, 2e-3, lower=True)
    assert solve_with_rests([campaign()], None, at_rest(true.output(ups(rng, 5)), SIGMA)) is None
    angle = np.linspace(0, 2 * np.pi, 30)
    flat = np.stack((np.cos(angle), np.sin(angle), 0 * angle), axis=1)
    noisy = true.output(flat) + SIGMA * rng.standard_normal((30, 3))
    assert solve_with_rests([campaign()], None, at_rest(noisy, SIGMA)) is None
    assert solve_with_rests([campaign()], None, None) is None


def test_an_imu_turned_in_its_cube_is_solved_in_its_own_axes() -> None:
    C_sb = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    rests, true = on_faces(4, 0.0)
    turned = replace(rests, rate=true.output(np.array([face_normal(f) for f in FACES]) @ C_sb.T))
    joint = solve_with_rests([campaign(fixture=Fixture(C_sb=C_sb))], None, turned)
    assert np.max(np.abs(errors(joint, true))) < 0.1


@pytest.mark.parametrize("spoil", ["constant", "copied", "zero"])
def test_accelerometers_that_say_nothing_determine_nothing(spoil: str) -> None:
    rng = np.random.default_rng(9)
    rate = unit(rng, 1000.0, 2e-3).output(ups(rng, 30)) + SIGMA * rng.standard_normal((30, 3))
    if spoil == "copied":
        rate[:, 1] = rate[:, 0]
    else:
        rate[:, 0] = {"constant": 5.0, "zero": 0.0}[spoil]
    rests = at_rest(rate, SIGMA)
    assert solve_with_rests([campaign()], None, rests) is None
    faces = tuple((0, RestRecord(f, FACES[i % 6], NO_SERIES)) for i, f in enumerate(map(str, range(30))))
    assert solve_with_rests([campaign()], None, replace(rests, rests=faces)) is None


# A fit without redundancy


@pytest.mark.parametrize(("attitudes", "is_reported"), [(10, True), (12, True), (13, False), (24, False)])
def test_a_fit_without_redundancy_is_reported(attitudes: int, is_reported: bool) -> None:
    rng = np.random.default_rng(attitudes)
    scale, bias = np.array([0.99, 1.01, 1.02]), np.array([0.03, -0.02, 0.05])
    rests = []
    for i, up in enumerate(ups(rng, attitudes)):
        t = 10.0 * i + 0.01 * np.arange(1, 301)
        accel = scale * up + bias + 1e-3 * rng.standard_normal((300, 3))
        rests.append(RestRecord(f"rest {i}", None, RateSeries(t, None, accel, np.full(300, np.nan), 0.01)))
    found = solve([Campaign("M", "S", False, Site(0.8, 9.80665, 1e-3), (), (), rests=tuple(rests))])
    assert found.accelerometer is not None
    warned = [text for text in found.warnings if f"{attitudes} rests determine 9 parameters" in text]
    assert bool(warned) == is_reported
