"""A rate output as counts, so that what guides an operator need know one kind of device only.

`RATE_UNIT` counts stand for one unit of the output times a second: so fine that what is granted to counting, a
sixteenth of a count squared, is nothing beside any unit's noise. What is recorded is the output itself.
"""

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.counts.sample_records import BLOCK_FIELDS, CountBlock, CountSeries, SampleBlock, Series

RATE_UNIT = 2.0**27


def as_counts(block: SampleBlock, period: float) -> CountBlock:
    """Return a block of ``period`` [s] as counts; a device that counts has sent them."""
    if isinstance(block, CountBlock):
        return block
    columns = {name: getattr(block, name) for name in BLOCK_FIELDS}
    return CountBlock(**(columns | {name: _counts(columns[name], period) for name in ("gyro", "accel")}))


def series_as_counts(series: Series) -> CountSeries:
    """Return a step's series as counts."""
    if isinstance(series, CountSeries):
        return series
    gyro, accel = (
        None if values is None else _counts(values, series.period) for values in (series.gyro, series.accel)
    )
    return CountSeries(series.t, gyro, accel, series.temperature, series.period, series.starts, series.extra)


def _counts(values: FloatArray, period: float) -> IntArray:
    return np.rint(values * (period * RATE_UNIT)).astype(np.int64)
