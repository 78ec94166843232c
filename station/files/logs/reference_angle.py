"""``--reference`` of an angle: an encoder's or a motor's beside the gyroscope that it turns."""

from collections.abc import Mapping

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.reference_angle import (
    LEAST_ROWS,
    SURE,
    lateness,
    mean_rates,
    slope_and_correlation,
    unwrapped,
)
from station.errors import DataRefused
from station.files.columns import TRIADS
from station.files.logs.log_columns import LogColumns
from station.files.output_units import GYRO_UNITS, outputs_per_unit

MAX_OFF = 0.02  # of 1, by which a told unit and the angle may differ before it is said
STEADY = 0.1  # of the mean rate: one that spans less is held against the whole angle, a line has no slope there
ANGLES = ("rate_ref_deg_s", "t_s", *TRIADS["gyro"], "temp_c")


def angle_at_ends(found: LogColumns) -> tuple[float, bool] | None:
    """Return by how much an angle grew [deg] that was read at both ends of a log alone; None of any other log.

    With it, whether the readings may begin again at each turn.
    """
    if found.reference is None or found.degrees_per_angle is None:
        return None
    angle = found.table.column(found.reference) * found.degrees_per_angle
    read = np.flatnonzero(np.isfinite(angle))
    if len(read) < 2 or read[0] >= len(angle) / 4 or read[-1] < len(angle) * 3 / 4:
        return None
    gap = int(np.argmax(np.diff(read)))
    if read[gap + 1] - read[gap] < len(angle) / 2:
        return None
    first, last = (float(np.median(angle[part])) for part in (read[: gap + 1], read[gap + 1 :]))
    return last - first, bool(min(first, last) >= 0 and max(first, last) <= 360)


def rates_of_angle(
    found: LogColumns, columns: Mapping[str, FloatArray], angle: FloatArray, notes: list[str]
) -> dict[str, FloatArray]:
    """Return a rate table's columns, a row a block, of a log with an ``angle`` (n,) [deg] beside it.

    Raises
    ------
    DataRefused
        If there are too few rows, or the angle does not move.
    """
    if len(angle) < LEAST_ROWS or not np.ptp(angle):
        what = f"{len(angle)} rows" if np.ptp(angle) else f"{found.reference} that never changes"
        raise DataRefused(found.table.file, None, what, f"at least {LEAST_ROWS} rows of an angle that turns")
    t, angle = columns["t_s"], unwrapped(angle)
    names = [name for name in ANGLES[2:] if name in columns]
    values = np.stack([columns[name] for name in names], axis=1)
    gyro = [i for i, name in enumerate(names) if name in TRIADS["gyro"]]
    turned = mean_rates(t, angle, values)
    likeness = [slope_and_correlation(turned.reference, turned.values[:, i])[1] for i in gyro]
    own = gyro[int(np.argmax(np.abs(likeness)))] if gyro else 0
    late, std = lateness(t, angle, values[:, own])
    if abs(late) > SURE * std:
        word = "late" if late > 0 else "early"
        notes.append(f"{found.reference} is {1e3 * abs(late):.1f} +- {1e3 * std:.2g} ms {word}: corrected")
        turned = mean_rates(t, angle, values, late)
    _say_scale(found, turned.reference, turned.values[:, own], notes)
    notes.append(
        f"{found.reference} turned by {angle[-1] - angle[0]:.6g} deg: {len(turned.t)} points of a rate table"
    )
    return {"rate_ref_deg_s": turned.reference, "t_s": turned.t, **dict(zip(names, turned.values.T, strict=True))}


def _say_scale(found: LogColumns, reference: FloatArray, output: FloatArray, notes: list[str]) -> None:
    """Say where the angle and the unit told do not agree: the scale factor, or the time, is another."""
    told = outputs_per_unit(found.unit_gyro or "raw", GYRO_UNITS)
    if told is None:
        return
    is_steady = np.ptp(reference) < STEADY * abs(np.mean(reference))
    slope = reference @ output / (reference @ reference) if is_steady else np.polyfit(reference, output, 1)[0]
    times = abs(float(slope) / told)
    if abs(times - 1) > MAX_OFF:
        more = f"the outputs turn {times:.4g} times as far as {found.reference}"
        why = "their unit is another, their bias is large," if is_steady else "their unit is another,"
        notes.append(f"{more}: {why} or the log's second is (--unit-time, --rate; --utc checks it)")
