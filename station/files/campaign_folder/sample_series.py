"""Columns to a series of samples: times, gaps and segments, cumulative outputs, the measured period."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.counts.sample_records import CountSeries, RateSeries, Series
from procedures.counts.sample_times import SampleTimes, sample_times
from procedures.counts.time_unit import unit_by_ratio
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.campaign_folder.campaign_schema import CampaignImuTable
from station.files.output_units import PLAUSIBLE_C
from station.files.tables.strict_csv import OUTPUTS, TRIADS
from station.files.tables.table import Table

WARN_PERIOD_DEVIATION = 1e-3  # relative, docs/how-to/campaign-folder.md
_MAX_GAPS_NAMED = 10


@dataclass(frozen=True, slots=True, eq=False)
class StepData:
    """What a step's file holds, a value per sample.

    ``times`` is what the stamps say.
    ``span`` is the first and last ``t_s`` [s]; ``host_span`` the station's time [ns] where the file has it;
    ``warnings`` what is legal but worth saying.
    """

    series: Series
    span: tuple[float, float]
    times: SampleTimes
    host_span: tuple[int, int] | None = None
    warnings: tuple[str, ...] = ()


def step_data(table: Table, imu: CampaignImuTable) -> StepData:
    """Give a step's columns their meaning.

    Raise `DataRefused` if ``t_s`` does not increase, or counts leave their word, add up beyond 2^62 or are too
    few.
    """
    t = table.columns["t_s"]
    refuse_time_backwards(table, np.diff(t))
    times = sample_times(t, imu.sample_period_s)
    begins, period = times.begins, times.period
    _refuse_other_unit(table, period / imu.sample_period_s)
    keep = np.ones(len(t), dtype=bool)
    if imu.output == "cumulative":
        keep[begins] = False  # the first row of a segment is its base: a difference across a gap is no sample
    if not keep.any():
        raise DataRefused(
            table.file, table.line(0), f"{len(t)} row(s)", "two rows in sequence, outputs being cumulative"
        )
    before = np.cumsum(keep) - keep
    starts = np.unique(before[begins])
    gyro, accel = (_outputs(table, names, imu, keep) for names in TRIADS.values())
    temperature = table.columns.get("temp_c", np.full(len(t), np.nan))[keep]
    _refuse_implausible(table, temperature, np.flatnonzero(keep))
    extra = {name: c[keep] for name, c in table.columns.items() if name not in {*OUTPUTS, "t_s", "temp_c"}}
    common = (temperature, period, starts[starts < keep.sum()], extra)
    series: Series
    if imu.output == "rate":
        series = RateSeries(times.t[keep], gyro, accel, *common)
    else:
        gyro_counts, accel_counts = (None if a is None else a.astype(np.int64) for a in (gyro, accel))
        series = CountSeries(times.t[keep], gyro_counts, accel_counts, *common)
    return StepData(
        series, (float(t[0]), float(t[-1])), times, table.host_span, tuple(_warnings(table, times, imu))
    )


def refuse_time_backwards(table: Table, step: FloatArray) -> None:
    """Refuse a file whose ``t_s`` does not increase by every ``step`` (n - 1,) [s]."""
    t = table.columns["t_s"]
    if len(bad := np.flatnonzero(step <= 0)):
        row = int(bad[0]) + 1
        found = f"t_s {t[row]:.9g} after {t[row - 1]:.9g}"
        todo = "correct the file"
        if t[row] == t[row - 1]:
            todo = "if one read returned several rows, give each its own time: the one before + sample_period_s"
        raise DataRefused(table.file, table.line(row), found, "t_s that increases from row to row", todo)


def _outputs(table: Table, names: tuple[str, ...], imu: CampaignImuTable, keep: BoolArray) -> FloatArray | None:
    if names[0] not in table.columns:
        return None
    values = np.stack([table.columns[name] for name in names], axis=1)
    if imu.output == "cumulative":
        if imu.wrap_bits is not None:
            _refuse_outside_word(table, values, names, imu.wrap_bits)
        values = np.diff(values, axis=0, prepend=values[:1])
        if imu.wrap_bits is not None:
            half = 2.0 ** (imu.wrap_bits - 1)
            values = (values + half) % (2 * half) - half
    if imu.output != "rate" and np.abs(values).sum() >= 2.0**62:
        raise DataRefused(table.file, None, "counts that add up beyond 2^62", "counts of a real device")
    kept: FloatArray = values[keep]
    return kept


def _refuse_other_unit(table: Table, ratio: float) -> None:
    if (unit := unit_by_ratio(ratio)) is not None:
        found = f"samples {ratio:.6g} times as far apart as sample_period_s"
        remedy = f"if t_s is in {unit.name}, multiply it by {unit.seconds:g}; else correct sample_period_s"
        raise DataRefused(table.file, None, found, "t_s in seconds", remedy, ErrorCode.TIME_UNIT)


def _refuse_implausible(table: Table, temperature: FloatArray, rows: IntArray) -> None:
    low, high = PLAUSIBLE_C
    if len(bad := np.flatnonzero((temperature < low) | (temperature > high))):
        found = f"{temperature[bad[0]]:.6g} in column temp_c"
        raise DataRefused(table.file, table.line(int(rows[bad[0]])), found, f"{low:g} to {high:g} degC")


def _refuse_outside_word(table: Table, values: FloatArray, names: tuple[str, ...], bits: int) -> None:
    unsigned = values.min() >= 0
    low, high = (0, 2**bits - 1) if unsigned else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    if len(bad := np.argwhere((values < low) | (values > high))):
        row, axis = (int(i) for i in bad[0])
        found = f"{values[row, axis]:.0f} in column {names[axis]}"
        raise DataRefused(table.file, table.line(row), found, f"{low} to {high}, wrap_bits being {bits}")


def _warnings(table: Table, times: SampleTimes, imu: CampaignImuTable) -> Iterator[str]:
    t, gaps = table.columns["t_s"], times.begins[1:]
    for row in gaps[:_MAX_GAPS_NAMED].tolist():
        yield f"{table.file}:{table.line(row)}: a gap of {t[row] - t[row - 1]:.6g} s at {t[row - 1] - t[0]:.7g} s"
    if len(gaps) > _MAX_GAPS_NAMED:
        yield f"{table.file}: {len(gaps) - _MAX_GAPS_NAMED} more gaps"
    if times.is_uneven:
        step = np.delete(np.diff(t), gaps - 1)
        yield (
            f"{table.file}: t_s increases in steps of {step.min():.3g} to {step.max():.3g} s, as of reads, not of "
            f"samples; the rows are treated as samples at a constant rate, period {times.period:.9g} s from this "
            "file alone"
        )
    if table.damage:
        yield f"{table.file}: {table.damage}; {table.rows} samples read"
    off = times.period / imu.sample_period_s - 1
    if abs(off) > WARN_PERIOD_DEVIATION:
        yield f"{table.file}: mean sample period {times.period:.9g} s is {off:+.2%} off sample_period_s"
