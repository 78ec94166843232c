"""Caches of what a diagnosis asks of an evidence again and again, cleared at its end.

They hold the evidence, its fits and the recordings: in a process that goes on, of the last diagnosis.
"""

from collections.abc import Iterator
from contextlib import contextmanager

from procedures.effects.temperature_history import known_histories, sensor_temperature
from procedures.evidence.candidates import noise_in_navigation_grade
from procedures.evidence.excitation import equal_bins
from procedures.evidence.linear_model import fit_with, fitted, variance_classes
from procedures.evidence.row_sums import row_sums
from procedures.evidence.thermal_soaks import block_rates, block_temperatures
from procedures.inference.smooth_functions import _sums as sums_of_rows
from procedures.samples.channel_noise import noise_as_is
from procedures.samples.held_samples import held_channel


@contextmanager
def clear_caches() -> Iterator[None]:
    """Clear the caches when a function or block is left."""
    try:
        yield
    finally:
        for each in (
            sums_of_rows,
            fit_with,
            fitted,
            row_sums,
            known_histories,
            sensor_temperature,
            noise_in_navigation_grade,
            variance_classes,
            block_rates,
            block_temperatures,
            equal_bins,
            held_channel,
            noise_as_is,
        ):
            each.cache_clear()
