"""Points of a turntable by hand: which outputs are read, design and scale, blocks, and the noise of a point."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.campaign.campaign import RateTable
from procedures.diagnosis.rate_points import RatePoints, noise_of, read_points
from procedures.diagnosis.rate_tables import RateTables
from procedures.effects.jump import gyroscope_columns
from procedures.effects.temperature_history import sensor_temperature
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


@pytest.mark.parametrize(("other", "is_read"), [(10.0, False), (9.95, False), (9.8, True), (0.0, True)])
def test_a_sensor_is_taken_in_where_its_rates_differ_by_a_hundredth(other: float, is_read: bool) -> None:
    assert (points(one_sensor(), np.where(np.arange(N) % 4, 10.0, other)) is not None) == is_read


def test_a_table_is_cut_into_nine_blocks_of_equal_length() -> None:
    found = points(one_sensor())
    assert found is not None
    assert np.bincount(found.block).tolist() == [5, 5, 5, 5, 4, 4, 4, 4, 4]
    assert [(number, of) for _, number, of in found.blocks] == [(i, 0) for i in range(1, 10)]
    np.testing.assert_allclose(found.temperature[[0, -1]], [20.0, 30.0])


@pytest.mark.parametrize(("n", "is_read"), [(36, True), (10, True), (9, False)])
def test_fewer_points_than_give_eight_second_differences_are_no_table(n: int, is_read: bool) -> None:
    assert (points(one_sensor()[:n], RATES[:n]) is not None) == is_read


@pytest.mark.parametrize(("turned", "is_read"), [(5, True), (4, False)])
def test_a_sensor_is_taken_in_where_half_of_that_were_turned(turned: int, is_read: bool) -> None:
    rates = np.where(np.arange(N) < turned, RATES, 0.0)
    assert (points(one_sensor(), rates) is not None) == is_read


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


def test_a_table_that_repeats_no_rate_is_judged_by_what_a_line_leaves() -> None:
    rates = np.linspace(-20.0, 20.0, N)
    found = points(np.where(np.isnan(one_sensor()), np.nan, 5.0 * rates[:, None]), rates)
    assert found is not None
    residual = 0.5 * (-1.0) ** np.arange(N)
    noise, dof = noise_of(found, residual)
    # An alternating residual is like none of the five shapes that are taken out, but for a thousandth of it
    assert noise == pytest.approx(1.482602 * 2.0 / np.sqrt(6.0) * np.sqrt(N / (N - 5)), rel=0.01)
    assert dof == pytest.approx(0.37 / 1.94 * 38)
    still, _ = noise_of(found, np.zeros(N))
    assert still == pytest.approx(1e-9 * 100.0)


def timed(name: str, begin_s: float, T: FloatArray) -> RateTable:
    """Return a table of a point every ten seconds."""
    u = np.tile(RATES, 3)[: len(T)]
    output = np.full((len(u), 3), np.nan)
    output[:, 2] = 5.0 * u + 1e-3 * np.random.default_rng(len(name)).standard_normal(len(u))
    return RateTable(name, "z", u, output, T, begin_s + 10.0 * np.arange(len(u)))


def followed(*tables: RateTable) -> FloatArray:
    made = RateTables.of([campaign(*tables)])
    assert made is not None
    return sensor_temperature(made.evidence().excitation, 100.0)


HEATED, COOLED = np.linspace(20.0, 50.0, 100), np.linspace(50.0, 20.0, 100)


def test_tables_whose_times_overlap_have_a_history_each() -> None:
    one, other = timed("heated.csv", 0.0, HEATED), timed("cooled.csv", 0.0, COOLED)
    np.testing.assert_allclose(followed(one, other), np.append(followed(one), followed(other)), atol=1e-9)
    made = RateTables.of([campaign(one, other)])
    assert made is not None
    seen = made.evidence().excitation
    heated = seen.step < 9
    for way in gyroscope_columns(seen):
        assert way.gyro is not None
        acts = way.gyro.any(axis=(1, 2))
        assert acts[heated].any() != acts[~heated].any()


def test_tables_one_after_the_other_have_one_history() -> None:
    one, other = timed("heated.csv", 0.0, HEATED), timed("cooled.csv", 1000.0, COOLED)
    behind = 100.0 * 30.0 / 990.0  # K, of a sensor that follows a ramp
    assert followed(one, other)[100] == pytest.approx(50.0 - behind * np.exp(-10.0 / 100.0), abs=1e-3)
    assert followed(other)[0] == pytest.approx(50.0)
