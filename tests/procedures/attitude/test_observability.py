import numpy as np

from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_velocity_aids import determinant, observability


def observability_matrix(rate: FloatArray, slope: FloatArray) -> FloatArray:
    """Return (13), (..., 3, 3), of ``rate`` (..., 3) [rad/s] and its derivative ``slope`` (..., 3) [rad/s2].

    The printed third row has ``p q + r`` for ``p q + dr/dt``, without which the units differ.
    """
    p, q, r = np.moveaxis(rate, -1, 0)
    dq, dr = slope[..., 1], slope[..., 2]
    one, nought = np.ones_like(p), np.zeros_like(p)
    rows = ((one, nought, nought), (nought, r, -q), (-r * r - q * q, p * q + dr, p * r - dq))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def test_the_determinant_is_that_of_the_matrix_and_of_a_system_that_varies_in_time() -> None:
    rng = np.random.default_rng(1)
    rate, slope = rng.standard_normal((20, 3)), rng.standard_normal((20, 3))
    assert np.allclose(np.linalg.det(observability_matrix(rate, slope)), determinant(rate, slope))

    def system(w: np.ndarray) -> np.ndarray:
        p, q, r = w
        return np.array([[0, r, -q], [-r, 0, p], [q, -p, 0]])

    top = np.array([1.0, 0.0, 0.0])
    second = top @ system(rate[0])  # rows of (13): N, N A + dN/dt, ...
    third = second @ system(rate[0]) + top @ system(slope[0])
    assert np.allclose(np.stack([top, second, third]), observability_matrix(rate[0], slope[0]))


def test_a_steady_turn_without_roll_rate_is_not_observable() -> None:
    rate = np.tile([0.0, 0.01, 0.03], (3000, 1))
    log = AttitudeLog(np.arange(3000) * 0.01, rate, np.zeros((3000, 3)))
    seen = observability(log, 2.5e-3)
    assert seen.open_s > 29
    assert seen.rank_3 == 0
    rate[:, 0] = 0.02
    assert observability(log, 2.5e-3).rank_3 > 0.9
    shut = observability(log, 1.0)  # the filter never ran: nothing was observable
    assert (shut.open_s, shut.determinant_rms, shut.rank_3) == (0.0, 0.0, 0.0)
