"""Points of a turntable by hand: which outputs are read, design and scale, blocks, and the noise of a point."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.diagnosis.rate_points import RatePoints, noise_of, read_points
from tests.procedures.diagnosis.test_rate_tables import campaign, table

N = 40
RATES = np.tile([-20.0, -10.0, 10.0, 20.0], 10)


def points(output: FloatArray, rates: FloatArray = RATES) -> RatePoints | None:
    made = replace(table(1), reference=rates, output=output, temperature=np.linspace(20.0, 30.0, len(rates)))
    return read_points([campaign(made)])


def one_sensor() -> FloatArray:
    output = np.full((N, 3), np.nan)
    output[:, 2] = 5.0 * RATES + 3.0
    return output


def test_an_output_is_read_where_it_is_a_number_of_a_sensor_that_was_turned() -> None:
    output = one_sensor()
    output[:, 0] = 1.0  # was not turned about its own axis
    output[[3, 17], 2] = np.nan
    found = points(output)
    assert found is not None
    assert found.at.tolist() == [i for i in range(N) if i not in (3, 17)]
    assert (found.sensor == 2).all()
    np.testing.assert_array_equal(found.output, (5.0 * RATES + 3.0)[found.at])
    np.testing.assert_allclose(found.omega, np.outer(RATES, [0.0, 0.0, 1.0]))
    assert found.parameters.tolist() == [[2, 2], [2, -1]]
    np.testing.assert_allclose(found.design(), np.stack((RATES[found.at], np.ones(38)), axis=1))
    assert np.isfinite(found.output).all()


def test_the_scale_is_the_length_of_a_row_with_the_sign_of_its_own_axis() -> None:
    found = points(one_sensor())
    assert found is not None
    skew = replace(found, parameters=np.array([[2, 0], [2, 2], [2, -1]]))
    np.testing.assert_allclose(skew.scale(np.array([3.0, -4.0, 99.0])), [np.nan, np.nan, -5.0])


def test_noise_is_judged_by_points_of_equal_rate_in_neighbouring_sweeps() -> None:
    """Sweeps are by turns one up and one down: second differences at a rate are 4, over the root of 6."""
    output = one_sensor()
    sweep = np.arange(N) // 4
    output[:, 2] += 100.0 * sweep + (-1.0) ** sweep  # what goes evenly with time cancels
    found = points(output)
    assert found is not None
    noise, dof = noise_of(found, np.zeros(N))
    assert noise == pytest.approx(1.482602 * 4.0 / np.sqrt(6.0))
    assert dof == pytest.approx(0.37 / 1.94 * 4 * 8)
