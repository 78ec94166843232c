import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.calibration.triad_calibration import scale_misalignment_bias, triad_vector
from procedures.campaign.campaign import FaceCertificate, Fixture
from procedures.positions import FACES
from procedures.twelve_positions.accelerometer_fit import (
    closed_form,
    missing_positions,
    solve_accelerometer,
)
from tests.procedures.independent import (
    TABLE_4_D,
    TABLE_4_E,
    TABLE_4_K,
    THETA,
    campaign,
    dwells,
    specific_force,
    table_3,
)

SIGMA = 1e-4  # count/s: 1e-7 g
EVERY = range(1, 13)


def paper_rates() -> FloatArray:
    return TABLE_4_K * (table_3(THETA) @ TABLE_4_E.T + TABLE_4_D)


def test_the_paper_s_unit_gives_the_errors_of_table_6() -> None:
    """Without noise; the paper prints, with noise, (1.6707, .6707, 1.0064)e-4 and (5.6, 6.9, 11.1)e-7."""
    form = closed_form(paper_rates(), np.ones((12, 3)))
    twelve, two = form.bias_12_position - TABLE_4_D, form.bias_two_direction - TABLE_4_D
    assert twelve == pytest.approx([1.6704e-4, 0.6711e-4, 1.0065e-4], abs=0.6e-8)  # a digit of the print
    assert two == pytest.approx([5.21e-7, 6.90e-7, 10.91e-7], abs=0.6e-9)
    assert twelve == pytest.approx(np.sin(THETA) * np.array([5 / 3, 2 / 3, 1]), rel=1e-2)  # eq. (19), to E's size


def test_the_paper_s_unit_gives_table_5() -> None:
    form = closed_form(paper_rates(), np.ones((12, 3)))
    assert form.scale_factor == pytest.approx(
        [1019.99867, 1014.99974, 1017.99936], abs=3e-4
    )  # 3 sigma of its noise
    printed = [[0.99999593, 0.00075038, 0.00275005], [0.00204977, 0.99999723, 0.00114942],
               [0.00285018, 0.0021493, 0.99999363]]  # fmt: skip
    assert form.misalignment == pytest.approx(np.array(printed), abs=1e-6)


def test_the_closed_form_is_equations_3_to_11_done_by_hand() -> None:
    N = np.random.default_rng(1).normal(size=(12, 3)) + paper_rates()
    form = closed_form(N, np.full((12, 3), 2.0))
    for q in range(3):
        n = [np.nan, *N[:, q]]  # numbered as in the paper
        K = [
            (n[1] + n[2] - n[3] - n[4]) / 4,
            (n[5] + n[6] - n[7] - n[8]) / 4,
            (n[9] + n[10] - n[11] - n[12]) / 4,
        ]
        k = np.sqrt(K[0] ** 2 + K[1] ** 2 + K[2] ** 2)
        two = [n[1] + n[2] + n[3] + n[4], n[5] + n[6] + n[7] + n[8], n[9] + n[10] + n[11] + n[12]][q]
        assert form.scale_factor[q] == pytest.approx(k, rel=1e-12)
        assert form.misalignment[q] == pytest.approx(np.array(K) / k, rel=1e-12)
        assert form.bias_12_position[q] == pytest.approx(sum(n[1:]) / 12 / k, rel=1e-10)
        assert form.bias_two_direction[q] == pytest.approx(two / 4 / k, rel=1e-10)
        assert form.bias_12_position_std[q] == pytest.approx(2.0 / np.sqrt(12) / k, rel=1e-12)
        assert form.bias_two_direction_std[q] == pytest.approx(2.0 / 2 / k, rel=1e-12)


def observed(
    seed: int, positions: tuple[int, ...], noise: float = SIGMA
) -> tuple[FloatArray, dict[str, FloatArray]]:
    """Rates of a random unit on a random cube and slab, by the independent geometry; and what was true."""
    rng = np.random.default_rng(seed)
    E = np.eye(3) + 1e-3 * rng.standard_normal((3, 3)) * ~np.eye(3, dtype=bool)
    E /= np.linalg.norm(E, axis=1)[:, None]
    truth = {
        "k": 1000 + 30 * rng.standard_normal(3), "E": E, "D": 2e-3 * rng.standard_normal(3),
        "faces": 5e-5 * rng.standard_normal((6, 2)), "slab": 5e-5 * rng.standard_normal(2),
    }  # fmt: skip
    headings = 1e-3 * rng.standard_normal(len(positions))
    u = specific_force(truth["faces"], truth["slab"], headings, positions)
    rate = truth["k"] * (u @ E.T + truth["D"]) + noise * rng.standard_normal((len(positions), 3))
    return rate, truth


def z_scores(seed: int, positions: tuple[int, ...] = tuple(EVERY)) -> FloatArray:
    """Errors of k, D, slab and parallelism in their own sigma."""
    rate, truth = observed(seed, positions)
    one = campaign()
    joint = solve_accelerometer([one], dwells(rate, SIGMA, positions))
    assert joint is not None
    found = triad_vector(joint, "accelerometer", joint)
    index = [0, 1, 2, 12, 13, 14]
    z = (found.value - np.concatenate((truth["k"], truth["E"].ravel(), truth["D"])))[index]
    z /= np.sqrt(np.diag(found.covariance))[index]
    p = truth["faces"][0::2] + truth["faces"][1::2]
    bench = joint.fit.x[12:]
    sigma = np.sqrt(np.diag(joint.fit.covariance))[12:]
    slab = (joint.bench.slab(bench, 0) - truth["slab"]) / sigma[:2]
    parallel = (joint.bench.parallelism(bench) - p).ravel() / sigma[3:9]
    return np.concatenate((z, slab, parallel))


@pytest.mark.parametrize("seed", range(2))
def test_the_joint_solve_recovers_the_truth_within_its_own_sigma(seed: int) -> None:
    assert np.all(np.abs(z_scores(seed)) < 4)


def test_the_joint_solve_s_sigmas_are_neither_too_small_nor_too_large() -> None:
    z = np.array([z_scores(seed) for seed in range(100, 140)])
    assert 0.85 < np.sqrt(np.mean(z**2)) < 1.15  # 560 values, correlated: 4 sigma of their rms
    assert np.all(np.sqrt(np.mean(z**2, axis=0)) < 1.5)  # 40 values each: 4.4 sigma


def test_the_paper_s_cube_is_solved_but_for_the_skew_that_its_items_do_not_predict() -> None:
    """Table 2's items put q at -p/4 and -p/8; P1's cube has other skews, each worth half its product with p."""
    joint = solve_accelerometer([campaign()], dwells(paper_rates(), SIGMA))
    assert joint is not None
    found = triad_vector(joint, "accelerometer", joint)
    p, q = np.array([[1, 3], [5, 3], [5, 3]]), np.array([[0.5, -1.5], [-2.5, 1.5], [-2.5, 1.5]])
    off = (q + p / np.array([[4], [8], [8]])) * THETA  # true q less the held one
    xy, xz, yz = off[0, 0] + off[1, 0], off[0, 1] + off[2, 0], off[1, 1] + off[2, 1]
    shift = np.array([xy * p[0, 0] + xz * p[0, 1], xy * p[1, 0] + yz * p[1, 1], xz * p[2, 0] + yz * p[2, 1]])
    error = found.value[12:] - TABLE_4_D
    assert error == pytest.approx(-shift * THETA / 2, abs=3e-9)  # E, 3e-3, turns 5e-7 of fitted tilts' squares
    assert np.all(np.abs(error) < 2 * np.sqrt(np.diag(found.covariance))[12:])
    assert np.all(np.abs(found.value[:3] - TABLE_4_K) < 2 * np.sqrt(np.diag(found.covariance))[:3])
    assert joint.bench.parallelism(joint.fit.x[12:]) == pytest.approx(p * THETA, rel=1e-3)


def test_misalignment_refers_to_the_mean_cube() -> None:
    rate, truth = observed(3, tuple(EVERY))
    joint = solve_accelerometer([campaign()], dwells(rate, SIGMA))
    assert joint is not None
    found = triad_vector(joint, "accelerometer", joint)
    normals = np.eye(3)
    for pair in range(3):
        others = [i for i in range(3) if i != pair]
        normals[others, pair] = (truth["faces"][2 * pair] - truth["faces"][2 * pair + 1]) / 2
    E = truth["E"] @ normals
    E /= np.linalg.norm(E, axis=1)[:, None]
    z = (found.value[3:12] - E.ravel()) / np.sqrt(np.diag(found.covariance))[3:12]
    assert np.abs(z[[1, 2, 3, 5, 6, 7]]).max() < 4


def test_an_imu_turned_in_the_cube_gives_the_same_numbers_in_its_own_axes() -> None:
    rate, _ = observed(4, tuple(EVERY))
    straight = solve_accelerometer([campaign()], dwells(rate, SIGMA))
    C_sb = np.array([[0.0, -1, 0], [0, 0, 1], [-1, 0, 0]])  # sensors x, y, z along cube -y, +z, -x
    turned_rate = rate @ C_sb.T
    turned = solve_accelerometer([campaign(fixture=Fixture(C_sb=C_sb))], dwells(turned_rate, SIGMA))
    assert straight is not None
    assert turned is not None
    a, b = (triad_vector(joint, "accelerometer", joint) for joint in (straight, turned))
    order = [1, 2, 0]
    assert b.value[:3] == pytest.approx(a.value[:3][order], rel=1e-10)
    assert b.value[12:] == pytest.approx((C_sb @ a.value[12:]), abs=1e-11)
    E = C_sb @ a.value[3:12].reshape(3, 3) @ C_sb.T
    assert b.value[3:12].reshape(3, 3) == pytest.approx(E, abs=1e-10)
    std = np.sqrt(np.diag(b.covariance))
    assert std[12:] == pytest.approx(np.sqrt(np.diag(a.covariance))[12:][order], rel=1e-4)


def test_a_certificate_is_a_prior() -> None:
    rate, truth = observed(5, tuple(EVERY))
    sigma = 5e-6
    faces = {face: FaceCertificate(truth["faces"][i], sigma**2 * np.eye(2)) for i, face in enumerate(FACES)}
    joint = solve_accelerometer([campaign(fixture=Fixture(faces))], dwells(rate, SIGMA))
    assert joint is not None
    found = triad_vector(joint, "accelerometer", joint)
    std = np.sqrt(np.diag(found.covariance))
    z = (found.value - np.concatenate((truth["k"], truth["E"].ravel(), truth["D"]))) / np.maximum(std, 1e-12)
    off = [3 + 1, 3 + 2, 3 + 3, 3 + 5, 3 + 6, 3 + 7]
    assert np.abs(z[[*off, 0, 1, 2, 12, 13, 14]]).max() < 4
    assert std[off] == pytest.approx(sigma / np.sqrt(2), rel=0.1)  # of a mean normal, two faces


def test_repeats_are_used_and_lower_the_sigma() -> None:
    rate, _ = observed(6, tuple(EVERY))
    once = solve_accelerometer([campaign()], dwells(rate, SIGMA))
    twice = solve_accelerometer([campaign()], dwells(np.vstack((rate, rate)), SIGMA, [*EVERY, *EVERY]))
    assert once is not None
    assert twice is not None
    a, b = (np.sqrt(np.diag(j.fit.covariance))[9:12] for j in (once, twice))
    assert b == pytest.approx(a / np.sqrt(2), rel=1e-3)


@pytest.mark.parametrize(
    "positions",
    [tuple(range(1, 12)), pytest.param((1, 3, 5, 7, 9, 11)), tuple(range(2, 13))],
)
def test_fewer_positions_solve_with_an_honest_sigma(positions: tuple[int, ...]) -> None:
    z = np.array([z_scores(seed, positions)[:6] for seed in range(20)])
    assert np.abs(z).max() < 4.5  # the largest of 120
    assert np.sqrt(np.mean(z**2)) < 1.25


def test_two_faces_do_not_determine_a_triad() -> None:
    rate, _ = observed(9, (1, 2, 3, 4))
    seen = dwells(rate, SIGMA, (1, 2, 3, 4))
    assert solve_accelerometer([campaign()], seen) is None
    assert missing_positions(seen) == [f"position {p}" for p in range(5, 13)]


def test_the_sigma_of_k_holds_gravity_s() -> None:
    rate, _ = observed(10, tuple(EVERY))
    joint = solve_accelerometer([campaign(gravity_std=5e-4)], dwells(rate, SIGMA))
    assert joint is not None
    found = triad_vector(joint, "accelerometer", joint)
    relative = np.sqrt(np.diag(found.covariance))[:3] / found.value[:3]
    assert relative == pytest.approx(5e-4 / 9.80665, rel=1e-3)
    k = found.covariance[:3, :3]
    assert k[0, 1] / np.sqrt(k[0, 0] * k[1, 1]) > 0.99  # one gravity for all three


@pytest.mark.parametrize("seed", range(2))
def test_the_jacobian_of_k_e_and_d_is_that_of_small_differences(seed: int) -> None:
    rng = np.random.default_rng(seed)
    K, b = 1000 * (np.eye(3) + 0.1 * rng.standard_normal((3, 3))), rng.standard_normal(3)
    _, J = scale_misalignment_bias(K, b, 3600.0)
    x = np.concatenate((K.ravel(), b))
    for i in range(12):
        d = np.zeros(12)
        d[i] = 1e-3
        up, down = (scale_misalignment_bias(v[:9].reshape(3, 3), v[9:], 3600.0)[0] for v in (x + d, x - d))
        assert J[:, i] == pytest.approx((up - down) / 2e-3, rel=1e-6, abs=1e-9)
