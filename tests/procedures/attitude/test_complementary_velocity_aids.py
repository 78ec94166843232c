"""The velocity aids of the complementary filter, a sample each, against You and Lee's equations in numpy."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.attitude import complementary_kernels as kernels
from procedures.attitude import complementary_velocity_aids as aids
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_kernels import (
    MIXER,
    PRINTED,
    PRINTED_FILTER,
    PRINTED_GNSS,
    PRINTED_RATE,
    MixerSettings,
)
from procedures.attitude.complementary_velocity_aids import determinant, observability
from procedures.attitude.kernel_options import Record
from tests.procedures.attitude.uncompiled import uncompiled

NAN = math.nan
RATE, FORCE = np.array([0.2, -0.3, 0.5]), np.array([0.6, -1.1, -9.2])
G = 9.8
LAW = MixerSettings(k1=0.4, k2=0.05, gate=0.1, g=G)


@pytest.fixture(autouse=True)
def as_python(monkeypatch: pytest.MonkeyPatch) -> None:
    uncompiled(monkeypatch, kernels, aids)


def mixer() -> Record:
    m = np.zeros(1, MIXER)
    aid = m[0]
    aid.down[:] = Rotation.from_euler("YX", (0.3, -0.2)).as_matrix().T[:, 2]
    aid.roll, aid.pitch, aid.correction[:] = -0.2, 0.3, (0.01, -0.02, 0.03)
    aid.velocity[:], aid.airspeed, aid.attack = (20.0, 1.5, 2.5), 21.0, 0.12
    aid.level[:], aid.level_rate[:] = (20.0, 2.0, -1.0), (1.2, -0.4, 0.3)
    aid.covariance[:] = [[4.0, 0.3, -0.2], [0.3, 5.0, 0.6], [-0.2, 0.6, 6.0]]
    return m


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize(("rate", "is_open"), [(0.099, False), (-0.099, False), (0.101, True), (-0.101, True)])
def test_the_gate_is_of_all_axes(axis: int, rate: float, is_open: bool) -> None:
    omega = np.zeros(3)
    omega[axis] = rate
    assert aids.open_gate(np.zeros(1, MIXER), LAW, 1.0, omega, FORCE, np.full(3, NAN)) == is_open
    both = np.full(3, rate / math.sqrt(3))
    assert aids.open_gate(np.zeros(1, MIXER), LAW, 1.0, both, FORCE, np.full(3, NAN)) == is_open


@pytest.mark.parametrize("is_open", [True, False])
def test_forward_speed_takes_off_what_a_turn_adds(is_open: bool) -> None:
    m, twin, level = mixer(), mixer(), np.full(3, NAN)
    m[0].smooth_rate[:] = RATE if is_open else 0.0
    m[0].elapsed_s = 1.0
    law = LAW if is_open else LAW._replace(gate=9.0)
    aids.mix_speed(m, law, 0.02, RATE, FORCE, level)
    velocity = 21.0 * np.array([math.cos(0.12), 0.0, math.sin(0.12)]) * is_open
    force = FORCE - np.cross(RATE, velocity)
    np.testing.assert_allclose(m[0].gravity, force)
    np.testing.assert_allclose(m[0].velocity[[0, 2]], velocity[[0, 2]])
    kernels.mix_vector(twin, 0.02, RATE, force, max(0.4, 1 / 1.12), 0.05)
    np.testing.assert_allclose(m[0].down, twin[0].down)
    learned = -0.12 + math.asin(-twin[0].down[0])
    assert m[0].learned_s == (0.0 if is_open else 0.02)
    if not is_open:
        assert m[0].attack == pytest.approx(math.asin(-mixer()[0].down[0]))
    assert learned != 0.0


@pytest.mark.parametrize(("roll", "pitch"), [(0.4, -0.3), (-1.2, 0.8), (0.0, 1.5)])
def test_the_angles_of_gravity_are_those_of_its_components(roll: float, pitch: float) -> None:
    """f = (g sin(theta) + x, y - g sin(phi) cos(theta), ...), eq. 9."""
    x, y = 0.7, -1.3
    force = np.array([G * math.sin(pitch) + x, y - G * math.sin(roll) * math.cos(pitch), 0.0])
    assert aids.angles_of_gravity(force, x, y, G) == pytest.approx((roll, pitch))


def test_a_turning_velocity_accelerates_by_the_cross_product() -> None:
    velocity = np.array([20.0, 1.5, 2.5])
    assert aids.acceleration_by_rates(velocity, RATE) == pytest.approx(tuple(np.cross(RATE, velocity)[:2]))


def test_with_a_heading_the_acceleration_is_that_of_the_level_velocity_seen_from_the_body() -> None:
    m = mixer()
    C_lb = Rotation.from_euler("YX", (0.3, -0.2)).as_matrix()  # forward, right, down of the heading
    turning = (RATE[1] * math.sin(-0.2) + RATE[2] * math.cos(-0.2)) / math.cos(0.3)
    expected = C_lb.T @ (np.array([1.2, -0.4, 0.3]) + np.cross([0.0, 0.0, turning], [20.0, 2.0, -1.0]))
    assert aids.whole_acceleration(m, RATE) == pytest.approx(tuple(expected[:2]))


@pytest.mark.parametrize("speed", [NAN, 23.0])
def test_a_sample_of_the_velocity_filter(speed: float) -> None:
    """v' = f - omega x v + g, P' = F P + P F' + Q, and the airspeed measured: You and Lee (11), (12)."""
    m, dt = mixer(), 0.02
    v, P = np.array([20.0, 1.5, 2.5]), np.array(mixer()[0].covariance)
    aids.filter_velocity(m, dt, RATE, FORCE, speed, G)
    gravity = G * np.array([-math.sin(0.3), math.sin(-0.2) * math.cos(0.3), math.cos(-0.2) * math.cos(0.3)])
    v = v + (FORCE - np.cross(RATE, v) + gravity) * dt
    F = np.eye(3) - np.array([np.cross(RATE, e) for e in np.eye(3)]).T * dt
    P = F @ P @ F.T + 2e-9 * np.eye(3)
    if speed == speed:
        gain = P[:, 0] / (P[0, 0] + 100.0)
        v, P = v + gain * (speed - v[0]), P - np.outer(gain, P[0])
    np.testing.assert_allclose(m[0].velocity, v, atol=1e-13)
    np.testing.assert_allclose(m[0].covariance, P, atol=1e-13)


@pytest.mark.parametrize("form", [PRINTED, PRINTED_FILTER, PRINTED_RATE, PRINTED_GNSS])
@pytest.mark.parametrize("is_open", [True, False])
def test_each_printed_form_takes_off_its_own_acceleration(form: int, is_open: bool) -> None:
    m, twin, level = mixer(), mixer(), np.full(3, NAN)
    law = LAW._replace(form=form, gate=0.1 if is_open else 9.0)
    for each in (m, twin):
        each[0].smooth_rate[:], each[0].has_turned, each[0].learned_s = RATE, float(form != PRINTED_FILTER), 1.0
    aids.mix_paper(m, law, 0.02, RATE, FORCE, level)
    aids.open_gate(twin, law, 0.02, RATE, FORCE, level)
    velocity = np.array([21.0, 1.5, 2.5])  # v and w are held
    if form == PRINTED_FILTER and is_open:
        aids.filter_velocity(twin, 0.02, RATE, FORCE, NAN, G)
        velocity = np.array(twin[0].velocity)
    elif form == PRINTED_FILTER:  # 1 s, and 0.02 s of pitch 0.3
        velocity[2] = 21.0 * math.tan(0.12 + 0.02 / 1.02 * (0.3 - 0.12))
    np.testing.assert_allclose(m[0].velocity, velocity)
    assert m[0].has_turned == float(is_open or form != PRINTED_FILTER)
    x, y = np.cross(RATE, velocity)[:2]
    if form == PRINTED_GNSS:
        x, y = aids.whole_acceleration(twin, RATE)
    x += 1.2 * (form == PRINTED_RATE)
    kernels.mix_euler(twin, 0.02, RATE, *aids.angles_of_gravity(FORCE, x, y, G), LAW.k1, LAW.k2)
    assert (m[0].roll, m[0].pitch) == pytest.approx((twin[0].roll, twin[0].pitch))
    assert m[0].learned_s == pytest.approx(1.0 if is_open else 1.02)


def observability_matrix(rate: FloatArray, slope: FloatArray) -> FloatArray:
    """Return (13), (..., 3, 3), of ``rate`` (..., 3) [rad/s] and its derivative ``slope`` (..., 3) [rad/s2].

    The printed third row has ``p q + r`` for ``p q + dr/dt``, without which the units differ.
    """
    p, q, r = np.moveaxis(rate, -1, 0)
    dq, dr = slope[..., 1], slope[..., 2]
    one, zero = np.ones_like(p), np.zeros_like(p)
    rows = ((one, zero, zero), (zero, r, -q), (-r * r - q * q, p * q + dr, p * r - dq))
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
