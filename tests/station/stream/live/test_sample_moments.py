"""Moments of samples: by the reads that lagged least, of a device that keeps its pace and of one that does not."""

import numpy as np
import pytest

from station.stream.live.sample_moments import SampleMoments


def test_samples_of_one_read_were_taken_one_after_another() -> None:
    moments = SampleMoments()
    reads = [(0.1, 1.0), (0.5, 1.0), (1.0, 1.0), (1.1, 2.003), (2.0, 2.003)]  # device time, read at [s]
    found = [moments.of(t, round(read * 1e9)) / 1e9 for t, read in reads]
    assert found[2:] == [1.0, 1.1, 2.0]
    moments.begin_anew()
    assert moments.of(0.0, 5 * 10**9) == 5 * 10**9


@pytest.mark.parametrize(("pace", "most_off"), [(1.0, 0.001), (0.9995, 0.04), (0.1, 0.2), (20.0, 0.2)])
def test_a_device_that_goes_slower_than_it_says_is_followed(pace: float, most_off: float) -> None:
    """The device's ``pace`` in its own seconds per second; each read is late by up to 0.3 s."""
    moments, rng = SampleMoments(), np.random.default_rng(3)
    device = 0.1 * np.arange(1, 2000)
    true = 5.0 + device / pace
    late = rng.exponential(0.03, len(device)).clip(0.0, 0.3)
    read = np.round((true + late) * 1e9).astype(np.int64)
    found = np.array([moments.of(t, at) / 1e9 for t, at in zip(device.tolist(), read.tolist(), strict=True)])
    assert (found <= read / 1e9).all()
    assert np.abs(found - true)[60:].max() < most_off
