"""The sine of an interferometer, near nought and beyond, against its series and against half angles."""

import math

import pytest

from station.calibrated import settling_kernels
from station.calibrated.settling_kernels import SERIES_BELOW

SINE = getattr(settling_kernels._sine, "py_func", settling_kernels._sine)  # noqa: SLF001


@pytest.mark.parametrize("y", [1e-9, 0.3 * SERIES_BELOW, 0.999 * SERIES_BELOW, 1.001 * SERIES_BELOW, 0.5])
@pytest.mark.parametrize("sign", [1, -1])
def test_what_a_sine_is_off_and_its_slope_are_those_of_the_functions(y: float, sign: int) -> None:
    u, x = 40.0, math.sqrt(y)
    off, slope = SINE(sign * y / u**2, u)
    series = math.fsum((-sign * y) ** k / math.factorial(2 * k + 1) for k in range(1, 12))
    half = math.sin(x / 2) if sign > 0 else math.sinh(x / 2)
    assert off == pytest.approx(u * series, rel=1e-11)
    assert slope == pytest.approx(-sign * 2 * half**2, rel=1e-11)
