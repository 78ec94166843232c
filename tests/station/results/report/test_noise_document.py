"""A channel's noise as a document: lines in the triad's unit, chances as powers of ten, spectra averaged."""

import math
from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.samples.channel_noise import channel_noise
from procedures.statistics.spectrum import Line
from procedures.units import DEG_H_PER_DEG_S
from station.results.report.noise_document import averaged, noise_channel, units_of


def test_a_line_is_in_micro_g_and_its_chance_a_power_of_ten() -> None:
    campaign = simulate_campaign(Truth.example(5), 7, dwell_s=60.0, positions=(1,), turns=())
    noise = channel_noise([campaign], {"accelerometer": np.full(3, 1000.0)})[0]
    line = Line(12.5, 0.01, 3e-6, 1e-7, 6 * math.log(0.1), 0.25)
    [found] = noise_channel(replace(noise, lines=(line,)), "output").lines
    assert found.log10_p == pytest.approx(-6.0)
    assert (found.amplitude, found.amplitude_std) == (pytest.approx(3.0), pytest.approx(0.1))
    assert (found.hertz, found.unit, found.share) == (12.5, "ug", 0.25)


def test_a_spectrum_is_averaged_evenly_in_the_logarithm_and_keeps_its_power() -> None:
    hertz = np.linspace(0.01, 50.0, 5000)
    few, density = averaged(hertz, 2.0 * np.ones(5000))
    assert len(few) <= 240
    assert np.all(density == 2.0)
    assert np.all(np.diff(few) > 0)


def test_a_triad_whose_scale_is_not_known_has_outputs() -> None:
    assert (units_of("gyroscope", False).unit, units_of("gyroscope", False).factor) == ("output", 1.0)
    assert units_of("gyroscope", True).factor == DEG_H_PER_DEG_S
    assert units_of("accelerometer", True).unit == "ug"
