"""The sine of a Sagnac interferometer against numpy's own functions, on both sides of nought."""

import numpy as np
import pytest

from procedures.effects.sagnac_sine import sine_less_one


def test_it_is_the_sine_over_its_angle_less_one_and_the_hyperbolic_one_of_a_negative_square() -> None:
    angle = np.array([[1e-6, 1e-3, 0.03], [0.3, 1.0, 3.0]])
    assert sine_less_one(angle**2) == pytest.approx(np.sinc(angle / np.pi) - 1, rel=1e-9, abs=1e-15)
    assert sine_less_one(-(angle**2)) == pytest.approx(np.sinh(angle) / angle - 1, rel=1e-6, abs=1e-12)
    assert sine_less_one(np.zeros((1, 3))).tolist() == [[0.0, 0.0, 0.0]]
