"""A line of one phase in all recordings is found below the noise of each; noise and other phases are none."""

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, Site, SoakRecord
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.result import Finding
from procedures.diagnosis.sample_effects import sample_effects

PERIOD, N, RECORDINGS, DEG_H = 0.1, 1000, 12, 3600.0
UNIT = {"gyroscope": np.ones(3), "accelerometer": np.ones(3)}


def times(apart_s: float) -> list[FloatArray]:
    return [np.asarray(apart_s * i + PERIOD * np.arange(1, N + 1), dtype=np.float64) for i in range(RECORDINGS)]


def found(t: list[FloatArray], rates: list[FloatArray]) -> tuple[Finding, ...]:
    soaks = tuple(
        SoakRecord(f"soak_{i}", 0, None, RateSeries(at, rate, None, np.full(N, 25.0), PERIOD))
        for i, (at, rate) in enumerate(zip(t, rates, strict=True))
    )
    return sample_effects([Campaign("m", "s", False, Site(0.8, 9.8, 0.02), (), (), soaks=soaks)], UNIT).findings


@pytest.mark.parametrize("apart", [150.0, 171.034])
def test_a_line_of_three_sigma_in_each_recording_is_found_in_all(apart: float) -> None:
    for seed in range(3):
        rng = np.random.default_rng(seed)
        hertz, size, t = rng.uniform(0.3, 4.0), np.array([0.0, 0.11, 0.08]), times(apart)
        rates = [rng.normal(size=(N, 3)) + np.sin(2 * np.pi * hertz * at[:, None] + 1.0) * size for at in t]
        (line,) = found(t, rates)
        assert line.effect == "disturbance.line"
        assert float(line.shape.split()[0]) == pytest.approx(hertz, abs=2e-4)
        sizes = dict(zip(line.coefficients, zip(line.value, line.std, strict=True), strict=True))
        for name, true in (("gy.cos1", np.sin(1.0) * 0.11), ("gy.sin1", np.cos(1.0) * 0.11)):
            value, std = sizes[name]
            assert abs(value - true * DEG_H) < 4.5 * std


def test_a_line_of_the_only_channel_that_lives_is_found() -> None:
    rng, t = np.random.default_rng(5), times(150.0)
    rates = [(rng.normal(size=N) + 0.12 * np.sin(2 * np.pi * 1.7 * at))[:, None] * [0.0, 0.0, 1.0] for at in t]
    (line,) = found(t, rates)
    assert (line.effect, float(line.shape.split()[0])) == ("disturbance.line", pytest.approx(1.7, abs=2e-4))


def test_noise_has_no_line() -> None:
    names = list[str]()
    for seed in range(8):
        rng = np.random.default_rng([seed, 7])
        names += [
            each.effect for each in found(times(150.0), [rng.normal(size=(N, 3)) for _ in range(RECORDINGS)])
        ]
    assert names == []
