"""One rest of a recording of moves and rests in which the specific force was not gravity's."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.campaign.campaign import Campaign, Site
from procedures.diagnosis.diagnose import diagnose
from procedures.free_positions.rest_detection import scatter_level
from procedures.inference.result import Diagnosis
from tests.procedures.free_units import PERIOD, sequence, unit

NOISE = 5e-4  # g, of a sample
STEP_S = 6.0  # a rest of 4 s and a move of 2 s


def diagnosed(disturbed: dict[int, float], seed: int = 1) -> Diagnosis:
    """Diagnose 20 rests, of which some have another specific force [g], along the one of gravity."""
    rng = np.random.default_rng(seed)
    accel = unit(rng, 1.0, 5e-3, lower=True)
    record = sequence(rng, accel, unit(rng, 1.0, 0.1), accel_noise=NOISE, gyro_noise=0.02)
    series, t = record.series, record.series.t - PERIOD / 2
    assert series.accel is not None
    output = np.array(series.accel)
    for number, size in disturbed.items():
        here = (t >= number * STEP_S) & (t < number * STEP_S + 4.0)
        output[here] *= 1 + size
    site = Site(0.55, 9.80665, 1e-4)
    record = replace(record, series=replace(series, accel=output))
    scale = {"accelerometer": 1.0, "gyroscope": 1.0}
    return diagnose([Campaign("M", "S", False, site, (), (), sequences=(record,), nominal_scale=scale)])


@pytest.mark.parametrize(("number", "size"), [(3, 2e-3), (9, -5e-3), (14, 2e-2)])
def test_the_rest_is_named_and_nothing_else(number: int, size: float) -> None:
    (found,) = diagnosed({number: size}).findings
    assert (found.effect, found.confidence) == ("disturbance.rest", "established")
    assert abs(float(str(found.where["from_s"])) - number * STEP_S) < 1.0
    assert abs(found.value[0] - size) < 5 * found.std[0] + 0.02 * abs(size)


def test_two_rests_are_named_both() -> None:
    found = diagnosed({3: 5e-3, 12: -8e-3}).findings
    assert [each.effect for each in found] == ["disturbance.rest"] * len(found)
    begun = {float(str(each.where["from_s"])) for each in found}
    assert len(begun) == 2
    assert all(min(abs(t - n * STEP_S) for n in (3, 12)) < 1.0 for t in begun)


def test_good_rests_have_no_such_name() -> None:
    assert diagnosed({}).findings == ()


def test_a_rest_of_few_samples_a_second_is_one() -> None:
    """A window of 21 samples scatters by a fifth: noise lifts its level above the multiplier now and then."""
    rng = np.random.default_rng(2)
    accel, gyro = unit(rng, 1.0, 5e-3), unit(rng, 1.0, 0.1)
    series = sequence(rng, accel, gyro, accel_noise=NOISE, gyro_noise=0.02).series
    every = slice(4, None, 5)
    assert series.accel is not None
    assert series.gyro is not None
    coarse = replace(
        series, t=series.t[every], accel=series.accel[every], gyro=series.gyro[every],
        temperature=series.temperature[every], period=5 * PERIOD,
    )  # fmt: skip
    assert len(scatter_level(coarse).rests(1.5)) == 20
