"""The complementary filter on the gravity vector and in Euler angles, by the sample, against equation 1."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.attitude import complementary_kernels as kernels
from procedures.attitude.complementary_kernels import MIXER
from procedures.attitude.kernel_options import Record
from tests.procedures.attitude.uncompiled import uncompiled

RATE, FORCE = np.array([0.2, -0.3, 0.5]), np.array([0.6, -1.1, -9.2])


@pytest.fixture(autouse=True)
def as_python(monkeypatch: pytest.MonkeyPatch) -> None:
    uncompiled(monkeypatch, kernels)


def mixer() -> Record:
    m = np.zeros(1, MIXER)
    aid = m[0]
    aid.down[:] = Rotation.from_euler("YX", (0.3, -0.2)).as_matrix().T[:, 2]
    aid.roll, aid.pitch, aid.correction[:] = -0.2, 0.3, (0.01, -0.02, 0.03)
    return m


def test_a_vector_turned_is_the_rotation_vectors() -> None:
    d, turn = np.array([0.3, -0.5, 0.8]), np.array([0.5, -0.4, 1.1])
    expected = Rotation.from_rotvec(-turn).apply(d)  # the body turns, the vector stays
    a2 = turn @ turn
    kernels.turn_vector(d, *turn, math.sin(math.sqrt(a2)) / math.sqrt(a2), (1 - math.cos(math.sqrt(a2))) / a2)
    np.testing.assert_allclose(d, expected, atol=1e-15)


@pytest.mark.parametrize("force", [(0.6, -1.1, -9.2), (0.6, -1.1, 9.2), (9.0, 1.0, -0.2), (0.0, 0.0, 0.0)])
def test_a_sample_of_the_filter_on_the_gravity_vector(force: tuple[float, ...]) -> None:
    """d' = -(omega + b + K1 e) x d, b' = K1 K2 e, e = d_a x d, of full length beyond a right angle."""
    m, d, b = mixer(), np.array(mixer()[0].down), np.array([0.01, -0.02, 0.03])
    kernels.mix_vector(m, 0.02, RATE, np.array(force), 0.4, 0.05)
    norm = np.linalg.norm(force)
    e = np.cross(-np.array(force) / norm, d) if norm else np.zeros(3)
    if norm and -np.array(force) @ d < 0:
        e /= np.linalg.norm(e)
    b += 0.4 * 0.05 * e * 0.02
    np.testing.assert_allclose(m[0].correction, b, atol=1e-15)
    expected = Rotation.from_rotvec(-(RATE + b + 0.4 * e) * 0.02).apply(d)
    np.testing.assert_allclose(m[0].down, expected, atol=1e-12)


@pytest.mark.parametrize("phi_a", [0.1, 0.1 + 2 * math.pi, 0.1 - 2 * math.pi])
def test_a_sample_of_the_filter_in_euler_angles(phi_a: float) -> None:
    """phi' = p + tan(theta) (q sin(phi) + r cos(phi)), theta' = q cos(phi) - r sin(phi), each plus K1 e and b."""
    m, phi, theta, dt = mixer(), -0.2, 0.3, 0.02
    p, q, r = RATE
    kernels.mix_euler(m, dt, RATE, phi_a, 0.15, 0.4, 0.05)
    e_phi, e_theta = 0.1 - phi, 0.15 - theta
    b = [0.01 + 0.4 * 0.05 * e_phi * dt, -0.02 + 0.4 * 0.05 * e_theta * dt]
    assert m[0].correction == pytest.approx([*b, 0.03])
    roll = p + math.tan(theta) * (q * math.sin(phi) + r * math.cos(phi)) + 0.4 * e_phi + b[0]
    assert m[0].roll == pytest.approx(phi + roll * dt)
    assert m[0].pitch == pytest.approx(theta + (q * math.cos(phi) - r * math.sin(phi) + 0.4 * e_theta + b[1]) * dt)


@pytest.mark.parametrize("sign", [-1, 1])
def test_near_the_vertical_the_tangent_is_that_of_89_9_deg(sign: int) -> None:
    m = mixer()
    m[0].roll, m[0].pitch, m[0].correction[:] = 0.0, sign * math.radians(89.99), 0.0
    kernels.mix_euler(m, 0.001, np.array([0.0, 0.0, 1.0]), 0.0, 0.0, 0.0, 0.0)
    assert m[0].roll == pytest.approx(sign * 573 * 0.001)
    assert math.tan(math.radians(89.9)) == pytest.approx(573, abs=0.05)
