"""Columns of a step's file as a series: what counts, gaps and periods become, row by row."""

from pathlib import Path

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.counts.sample_records import CountSeries, RateSeries
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import CampaignImuTable
from station.files.campaign_folder.sample_series import step_data
from station.files.tables.strict_csv import OUTPUTS
from station.files.tables.table import Table
from tests.refusals import refused

PERIOD = 0.01


def table(t: FloatArray, values: FloatArray, **more: FloatArray) -> Table:
    return Table(
        Path("a.csv"),
        {"t_s": t, **dict(zip(OUTPUTS, values.T, strict=False)), **more},
        lines=range(2, 2 + len(t)),
    )


def imu(output: str, bits: int | None = None, period: float = PERIOD) -> CampaignImuTable:
    asked = {"model": "m", "serial": "s", "sample_period_s": period, "output": output, "wrap_bits": bits}
    return CampaignImuTable.model_validate({k: v for k, v in asked.items() if v is not None})


T = PERIOD * np.array([1, 2, 3, 7, 8, 9, 10])  # a gap of four periods behind the third row
RISING = np.cumsum(np.arange(42.0).reshape(7, 6), axis=0)


def test_increments_are_taken_as_they_are() -> None:
    extra = np.arange(7.0)
    found = step_data(table(T, RISING, temp_c=extra, aux_case=2 * extra), imu("increments"))
    assert isinstance(found.series, CountSeries)
    np.testing.assert_array_equal(np.hstack((found.series.gyro, found.series.accel)), RISING)
    np.testing.assert_array_equal(found.series.temperature, extra)
    np.testing.assert_array_equal(found.series.extra["aux_case"], 2 * extra)
    assert set(found.series.extra) == {"aux_case"}
    assert found.series.starts.tolist() == [0, 3]
    assert found.series.period == pytest.approx(PERIOD)
    assert found.span == (0.01, 0.1)
    assert found.warnings[0].startswith("a.csv:5: ")
    assert found.warnings[0].endswith(f" at {2 * PERIOD:g} s")  # behind the third row


def test_running_totals_lose_the_first_row_of_each_stretch() -> None:
    found = step_data(table(T, RISING), imu("cumulative"))
    steps = np.diff(RISING, axis=0)
    np.testing.assert_array_equal(found.series.gyro, steps[[0, 1, 3, 4, 5], :3])
    np.testing.assert_array_equal(found.series.t, T[[1, 2, 4, 5, 6]])
    assert found.series.starts.tolist() == [0, 2]
    assert found.series.accel is not None
    assert found.series.accel.dtype == np.int64


def test_rates_stay_numbers_and_a_triad_may_be_missing() -> None:
    found = step_data(table(T, RISING[:, :3] / 7), imu("rate"))
    assert isinstance(found.series, RateSeries)
    np.testing.assert_array_equal(found.series.gyro, RISING[:, :3] / 7)
    assert found.series.accel is None
    assert np.isnan(found.series.temperature).all()


@pytest.mark.parametrize(("bits", "low"), [(16, 0), (16, -(2**15)), (24, 0), (32, -(2**31))])
def test_totals_of_a_word_wrap_at_its_size(bits: int, low: int) -> None:
    truth = np.cumsum(np.tile([[1000, -1000, 5000, 0, 2 ** (bits - 1) - 1, -(2 ** (bits - 1))]], (6, 1)), axis=0)
    wrapped = (truth - low) % 2**bits + low
    found = step_data(table(PERIOD * np.arange(6.0), wrapped.astype(float)), imu("cumulative", bits))
    assert found.series.gyro is not None
    assert found.series.accel is not None
    np.testing.assert_array_equal(np.hstack((found.series.gyro, found.series.accel)), np.diff(truth, axis=0))


@pytest.mark.parametrize(
    ("value", "low", "reported"),
    [
        (65535.0, 0.0, ""),
        (65536.0, 0.0, "65536"),
        (32767.0, -1.0, ""),
        (32768.0, -1.0, "32768"),
        (-32768.0, 0.0, ""),
        (-32769.0, 0.0, "-32769"),
    ],
)
def test_a_count_outside_its_word_is_refused(value: float, low: float, reported: str) -> None:
    values = np.zeros((4, 6))
    values[0, 0], values[2, 1] = low, value
    if not reported:
        step_data(table(PERIOD * np.arange(4.0), values), imu("cumulative", 16))
        return
    with refused(DataRefused, None, reported, "gy"):
        step_data(table(PERIOD * np.arange(4.0), values), imu("cumulative", 16))


@pytest.mark.parametrize("third", [0.015, 0.02])
def test_time_that_does_not_rise_is_refused_with_its_line(third: float) -> None:
    with refused(DataRefused, line=4):
        step_data(table(np.array([0.01, 0.02, third, 0.04]), RISING[:4]), imu("increments"))


@pytest.mark.parametrize(
    ("stated", "warns"), [(0.01, False), (0.010009, False), (0.0100112, True), (0.0099888, True)]
)
def test_a_period_a_thousandth_off_the_one_stated_is_reported(stated: float, warns: bool) -> None:
    t = PERIOD * np.arange(400)
    found = step_data(table(t, np.zeros((400, 6))), imu("increments", period=stated))
    reported = [each for each in found.warnings if "off sample_period_s" in each]
    assert bool(reported) == warns
    if warns:
        assert f"{0.01 / stated - 1:+.2%} off" in reported[0]
