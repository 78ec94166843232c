"""One period for files whose stamps are reads: a mean by sigma, widened where the files do not agree."""

from typing import cast

import numpy as np
import pytest

from procedures.counts.sample_records import RateSeries
from procedures.counts.sample_times import SampleTimes
from station.files.campaign_folder.campaign_schema import StepTable
from station.files.campaign_folder.common_sample_period import with_one_period
from station.files.campaign_folder.loaded_campaign import LoadedStep
from station.files.campaign_folder.sample_series import StepData

T = 5.0 + 0.01 * np.arange(101)


def step(period: float, std: float, is_uneven: bool = True) -> LoadedStep:
    series = RateSeries(T, None, np.zeros((101, 3)), np.full(101, np.nan), period)
    times = SampleTimes(T, period, np.zeros(1, np.int64), is_uneven, std)
    return LoadedStep("position", cast(StepTable, None), StepData(series, (5.0, 6.0), times))


def test_periods_that_agree_are_averaged_by_their_sigmas() -> None:
    steps = [step(0.01 + 1e-7, 1e-7), step(0.01 - 1e-7, 2e-7), step(0.0099, 1.0, is_uneven=False)]
    found, std, said = with_one_period(steps)
    mean = 0.01 + (1e-7 * 4 - 1e-7) / 5
    assert [each.data.series.period for each in found if each.data] == pytest.approx(
        [mean, mean, 0.0099], rel=1e-12
    )
    weights = 1e14 + 0.25e14
    spread = (1e14 * (1e-7 - (mean - 0.01)) ** 2 + 0.25e14 * (1e-7 + (mean - 0.01)) ** 2) / 1
    assert spread < 1.0
    assert std == pytest.approx(1 / np.sqrt(weights) / mean)
    assert f"{mean:.9g} s +- {1e6 * std:.2g} ppm" in said[0]
    series = found[0].data.series if found[0].data else None
    assert series is not None
    np.testing.assert_allclose(series.t, 5.5 + (T - 5.5) * mean / (0.01 + 1e-7), rtol=1e-12)
    assert found[2] is steps[2]


def test_files_that_differ_by_more_than_their_sigmas_widen_it() -> None:
    offs = np.array([-3e-7, 0.0, 3e-7])
    _, std, _ = with_one_period([step(0.01 + off, 1e-7) for off in offs])
    assert std == pytest.approx(np.sqrt(18 / 2 / 3) * 1e-7 / 0.01, rel=1e-4)


@pytest.mark.parametrize(
    ("off", "std", "is_near"),
    [
        (0.9e-5, 1e-7, True),
        (1.1e-5, 1e-7, False),
        (3.9e-5, 1e-5, True),
        (4.1e-5, 1e-5, False),
    ],
)
def test_a_file_of_quite_another_period_keeps_its_own(off: float, std: float, is_near: bool) -> None:
    for other in (0.01 + off, 0.01 - off):
        steps = [step(0.01, 1e-7), step(0.01, 1e-7), step(other, std)]
        found, _, _ = with_one_period(steps)
        assert (found[2] is not steps[2]) == is_near
