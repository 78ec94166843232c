"""Six faces set by hand: bias and scale factor of each axis, from truths that the test plants itself."""

from collections.abc import Sequence

import numpy as np
import pytest

from procedures.free_positions.norm_fit import Lack, NormFit, Undetermined, fit_norm

FACES = np.array([[0, 0, 1], [0, 0, -1], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]], dtype=float)
PER_G, NOISE = 16384.0, 1.0  # output per g of a board in raw counts, 1 sigma of a rest's mean
CROSS_AXIS = 0.015 / 2**0.5  # rad, 1 sigma of each of the two that make an angle between sensors: 0.015 together


def planted(
    seed: int, faces: Sequence[int], tilt: float = 0.02, cross: float = CROSS_AXIS
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return scale factor (3,) [output/g], bias (3,) [g] and mean outputs (n, 3) of rests near ``faces``."""
    rng = np.random.default_rng(seed)
    M = np.eye(3) + cross * rng.standard_normal((3, 3)) * (1 - np.eye(3))
    M /= np.linalg.norm(M, axis=1)[:, None]
    k, D = PER_G * (1 + 0.02 * rng.standard_normal(3)), 0.03 * rng.standard_normal(3)
    up = FACES[list(faces)] + tilt * rng.standard_normal((len(faces), 3))
    up /= np.linalg.norm(up, axis=1)[:, None]
    return k, D, (up @ M.T + D) * k + NOISE * rng.standard_normal((len(faces), 3))


def solved(rate: np.ndarray) -> NormFit:
    found = fit_norm(rate, np.full(rate.shape, NOISE), 1.0)
    assert isinstance(found, NormFit), found
    return found


def errors_in_sigma(found: NormFit, k: np.ndarray, D: np.ndarray) -> np.ndarray:
    """Return (6,) errors of scale factor and bias over their own standard uncertainty."""
    value, covariance = found.scale_and_bias()
    return (value - np.concatenate((k, D))) / np.sqrt(np.diag(covariance))


@pytest.mark.proof
@pytest.mark.parametrize(
    ("faces", "tilt"),
    [
        ((0, 1, 2, 3, 4, 5), 0.02),  # six faces within a degree or two
        ((0, 1, 2, 3, 4, 5), 0.002),  # set against a square
        ((0, 1, 2, 3, 4, 5), 0.08),  # by eye
        ((0, 1, 2, 3, 4, 5, 0), 0.02),  # one face twice
        ((2, 3, 2, 3, 4, 5, 0, 1), 0.04),
        ((0, 1, 2, 3, 4, 5, 0, 2, 4), 0.02),
        ((0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 4, 5), 0.02),  # twice
    ],
)
def test_sigma_is_the_size_of_the_errors_of_bias_and_scale_factor(faces: tuple[int, ...], tilt: float) -> None:
    z = [errors_in_sigma(solved(rate), k, D) for k, D, rate in (planted(s, faces, tilt) for s in range(120))]
    assert 0.8 < np.sqrt(np.mean(np.square(z))) < 1.2
    assert np.max(np.abs(z)) < 7  # of squares of angles: their tails are longer


def test_a_tilt_of_a_degree_costs_less_than_a_milli_g() -> None:
    for seed in range(20):
        k, D, rate = planted(seed, range(6))
        value, _ = solved(rate).scale_and_bias()
        assert np.max(np.abs(value[3:] - D)) < 2e-3
        assert np.max(np.abs(value[:3] / k - 1)) < 2e-3


def test_misalignment_is_listed_where_the_rests_stand_on_the_faces() -> None:
    exact = solved(planted(1, range(6), tilt=1e-3)[2])
    assert exact.not_observable == ("misalignment.yx", "misalignment.zx", "misalignment.zy")
    assert np.sqrt(exact.fit.covariance[1, 1]) / exact.K[0, 0] > 0.01  # as wide as what is assumed of it


def test_attitudes_between_the_faces_show_the_misalignment() -> None:
    rng = np.random.default_rng(4)
    up = rng.standard_normal((20, 3))
    up /= np.linalg.norm(up, axis=1)[:, None]
    E = np.array([[1, 0, 0], [0.09, 1, 0], [-0.07, 0.05, 1]])  # far beyond what is assumed of usual units
    found = solved((up @ E.T) * PER_G + NOISE * rng.standard_normal((20, 3)))
    assert found.not_observable == ()
    # In the rows' own length, of which the sigma is that of the noise alone
    np.testing.assert_allclose(found.K / PER_G, E, atol=4e-4)


@pytest.mark.parametrize("missing", range(6))
def test_a_face_that_is_missing_is_named_by_its_axis(missing: int) -> None:
    _, _, rate = planted(missing, [i for i in range(6) if i != missing])
    found = fit_norm(rate, np.full(rate.shape, NOISE), 1.0)
    assert isinstance(found, Undetermined)
    assert found.lack is Lack.ONE_SIDED
    assert found.sides == {"zzxxyy"[missing]: "up only" if missing % 2 else "down only"}
