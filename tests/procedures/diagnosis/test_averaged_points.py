"""Long rate tables: rows side by side at one rate are averaged; few rows stay; sigma stays honest."""

from unittest import mock

import numpy as np

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, RateTable, Site
from procedures.diagnosis.diagnose import diagnose
from procedures.evidence import rate_points
from procedures.evidence.rate_points import FEW_ROWS, averaged

PLATEAUS = [0, 10, -10, 20, -20, 40, -40, 60, -60, 80, -80, 100, -100, 150, -150, 0]
NOISE = 1.2e-3  # deg/s


def table(reference: FloatArray, seed: int, cubic: float = 2e-8) -> RateTable:
    rng = np.random.default_rng(seed)
    output = np.full((len(reference), 3), np.nan)
    noise = NOISE * rng.standard_normal(len(reference))
    output[:, 2] = 0.003 + 1.001 * reference + cubic * reference**3 + noise
    temperature = 25 + 1e-4 * np.arange(len(reference))
    return RateTable("rates.csv", "z", reference, output, temperature)


def reported(one: RateTable) -> FloatArray:
    """Return scale factor, bias and cubic, and 1 sigma of each, (3, 2)."""
    found = diagnose([Campaign("A", "1", False, Site(0.7, 9.8, 1e-3), (), (), rate_tables=(one,))])
    (sensor,), finding = found.on_table, found.findings[0]
    assert finding.effect == "gyroscope.scale_nonlinearity"
    return np.array([
        [sensor.scale, sensor.scale_std], [sensor.bias, sensor.bias_std], [finding.value[0], finding.std[0]]
    ])  # fmt: skip


def by_all_rows(one: RateTable) -> FloatArray:
    with mock.patch.object(rate_points, "FEW_ROWS", 10_000):
        return reported(one)


def test_a_table_of_few_rows_stays_exactly_as_it_is() -> None:
    one = table(np.repeat(np.array(PLATEAUS, float), FEW_ROWS // 16), 1)
    same, count = averaged(one)
    assert same is one
    assert set(count) == {1.0}


def test_means_of_many_rows_give_scale_factor_bias_and_cubic_within_their_sigma() -> None:
    one = table(np.repeat(np.array(PLATEAUS, float), 200), 2)
    means = reported(one)
    truth = np.array([1.001, 3600 * 0.003, 1e6 * 2e-8])
    assert np.all(np.abs(means[:, 0] - truth) < 4 * means[:, 1])


def test_absent_outputs_and_temperatures_do_not_spoil_their_neighbours() -> None:
    one = table(np.repeat(np.array(PLATEAUS, float), 200), 5)
    one.output[100:120, 2] = np.nan
    one.temperature[::2] = np.nan
    points, count = averaged(one)
    assert count[np.isnan(points.output[:, 2])].sum() == 20
    assert np.isfinite(points.temperature).all()
