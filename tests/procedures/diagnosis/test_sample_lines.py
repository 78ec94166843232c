"""Lines of another phase in every recording, or that wander, are found with their size; resonances are none."""

import numpy as np
import pytest
from scipy.signal import lfilter

from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, Site, SoakRecord
from procedures.counts.sample_records import RateSeries
from procedures.inference.result import Finding
from procedures.samples.sample_effects import sample_effects

PERIOD, N, DEG_H = 0.1, 1000, 3600.0
UNIT = {"gyroscope": np.ones(3), "accelerometer": np.ones(3)}


def held(*rates: FloatArray) -> Campaign:
    """Return recordings of gyroscopes (n, 3) one after the other."""
    soaks = list[SoakRecord]()
    for i, rate in enumerate(rates):
        t = 10_000.0 * i + PERIOD * np.arange(1, len(rate) + 1)
        soaks.append(SoakRecord(f"soak_{i}", 0, None, RateSeries(t, rate, None, np.full(len(t), 25.0), PERIOD)))
    return Campaign("m", "s", False, Site(0.8, 9.8, 0.02), (), (), soaks=tuple(soaks))


def found(campaign: Campaign) -> tuple[Finding, ...]:
    return sample_effects([campaign], UNIT).findings


def test_a_weak_line_of_another_phase_in_every_recording_is_found_with_its_amplitude() -> None:
    for seed in range(2):
        rng = np.random.default_rng(seed)
        hertz, turns = rng.uniform(0.3, 4.0), PERIOD * np.arange(N)[:, None]
        waves = [0.2 * np.sin(2 * np.pi * (hertz * turns + rng.random())) for _ in range(12)]
        rates = [rng.normal(size=(N, 3)) + wave * [1.0, 1.0, 0.0] for wave in waves]
        (finding,) = found(held(*rates))
        assert finding.effect == "disturbance.line"
        assert finding.probability > 0.9  # twelve powers rule out a narrow resonance no better
        assert float(finding.shape.split()[0]) == pytest.approx(hertz, abs=0.01)
        assert finding.shape.endswith("in 12 stretches of 98 s; it may be any multiple of 10 Hz away")
        sizes = dict(zip(finding.coefficients, zip(finding.value, finding.std, strict=True), strict=True))
        for name in ("gx", "gy"):
            value, std = sizes[name]
            assert abs(value - 0.2 * DEG_H) < 4 * std
        assert finding.share == pytest.approx(0.02 / 1.02, rel=0.4)


def test_a_line_whose_frequency_drifts_by_many_of_the_record_s_own_is_found() -> None:
    for seed in range(1):
        rng = np.random.default_rng(seed)
        n = 40_000
        hertz = 1.7 + 2e-4 * np.cumsum(rng.normal(size=n)) * np.sqrt(PERIOD)  # 0.01 Hz after 4000 s
        wave = 0.4 * np.sin(2 * np.pi * PERIOD * np.cumsum(hertz))
        (finding,) = found(held(rng.normal(size=(n, 3)) + wave[:, None] * [0.0, 0.0, 1.0]))
        assert finding.effect == "disturbance.line"
        assert float(finding.shape.split()[0]) == pytest.approx(1.7, abs=0.03)
        sizes = dict(zip(finding.coefficients, finding.value, strict=True))
        assert sizes["gz"] == pytest.approx(0.4 * DEG_H, rel=0.15)  # what wanders out of its bins is not counted


def noise(rng: np.random.Generator, n: int, colour: str) -> FloatArray:
    white = rng.normal(size=(n, 3))
    if colour == "walk":
        return np.cumsum(white, axis=0)
    radius, hertz = {"resonance": (0.99, 1.3), "narrow": (0.998, 2.1)}.get(colour, (0.0, 0.0))
    turned = [1, -2 * radius * np.cos(2 * np.pi * hertz * PERIOD), radius**2]
    return white if not radius else lfilter([1], turned, white, axis=0)


@pytest.mark.parametrize("colour", ["white", "walk", "resonance", "narrow"])
def test_noise_and_resonances_that_it_drives_have_no_lines(colour: str) -> None:
    for seed in range(2):
        rng = np.random.default_rng(seed)
        many = [noise(rng, N + 500, colour)[500:] for _ in range(12)]
        assert not found(held(*many))
        if colour != "narrow":
            assert not found(held(noise(rng, 20_500, colour)[500:]))


def test_a_line_in_one_recording_alone_is_none_of_all() -> None:
    rng = np.random.default_rng(1)
    rates = [rng.normal(size=(N, 3)) for _ in range(12)]
    rates[4] += 5 * np.sin(2 * np.pi * 0.77 * PERIOD * np.arange(N))[:, None]
    assert not found(held(*rates))
