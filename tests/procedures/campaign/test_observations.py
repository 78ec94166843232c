"""Rates of dwells that count and of dwells that send rates, each of a truth that is known."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.campaign.campaign import Campaign, DwellRecord, Fixture, ProcedureSigma, Site, period_std
from procedures.campaign.observations import dwell_rates
from procedures.campaign.plan_steps import Dwell, Turn, dwell_steps, turn_steps
from procedures.counts.sample_records import CountSeries, RateSeries
from procedures.positions import TURN_START
from tests.procedures.independent import campaign

PERIOD, TRUE = 0.01, np.array([1010.3, -987.6, 12.4])


def dwell(position: int, counts: bool = True, n: int = 1000) -> DwellRecord:
    t, rng = PERIOD * np.arange(1.0, n + 1), np.random.default_rng(position)
    output = TRUE + 0.5 * rng.standard_normal((n, 3))
    warm = np.full(n, 25.0)
    if not counts:
        return DwellRecord(f"d{position}", position, RateSeries(t, None, output, warm, PERIOD))
    running = np.floor(np.vstack((np.zeros(3), np.cumsum(output * PERIOD, axis=0))))
    return DwellRecord(
        f"d{position}", position, CountSeries(t, None, np.diff(running, axis=0).astype(int), warm, PERIOD)
    )


@pytest.mark.parametrize("counts", [True, False])
@pytest.mark.parametrize("positions", [(5,), (1, 2, 3)])
def test_rates_of_one_dwell_or_several_are_the_truth_within_their_sigma(
    counts: bool, positions: tuple[int, ...]
) -> None:
    seen = dwell_rates([replace(campaign(), dwells=tuple(dwell(p, counts) for p in positions))], "accelerometer")
    assert seen is not None
    assert [record.position for _, record in seen.dwells] == list(positions)
    assert np.all(np.abs(seen.rate - TRUE) < 4 * seen.std)
    assert np.all(seen.std < 0.1)
    assert dwell_rates([replace(campaign(), dwells=(dwell(1),))], "gyroscope") is None


def test_each_campaign_has_its_own_period_and_kind() -> None:
    both = [replace(campaign(), dwells=(dwell(1),)), replace(campaign(), dwells=(dwell(2, counts=False),))]
    seen = dwell_rates(both, "accelerometer")
    assert seen is not None
    assert [number for number, _ in seen.dwells] == [0, 1]
    assert np.all(np.abs(seen.rate - TRUE) < 4 * seen.std)


# The time base of several campaigns


def test_it_is_that_of_the_worst() -> None:
    campaigns = [
        Campaign(
            "M", "S", True, Site(0.8, 9.8, 1e-5), (), (), ProcedureSigma(1e-3, 1e-4), Fixture(), period_std=std
        )
        for std in (1e-6, 3e-5, 2e-6)
    ]
    assert period_std(campaigns) == 3e-5


def test_a_plan_asks_for_twelve_dwells_in_order() -> None:
    assert dwell_steps(60.0) == tuple(Dwell(p, 60.0) for p in range(1, 13))


def test_a_plan_asks_for_both_directions_about_every_axis() -> None:
    assert turn_steps(3, 5.0) == tuple(Turn(a, d, 3, TURN_START[a], 5.0) for a in "xyz" for d in "+-")
