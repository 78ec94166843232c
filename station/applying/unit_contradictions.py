"""What a log says of units and time beside what the calibration and --rate say: they must not contradict."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from procedures.arrays import FloatArray
from station.applying.source import Told
from station.errors import DataRefused
from station.files.logs.header_guesses import split_unit
from station.files.output_units import ACCEL_UNITS, GYRO_UNITS, RAW, outputs_per_unit

MAX_TIMES_OFF = 1.25  # of a scale factor from what a unit makes it: two units differ by more
MAX_RATE_OFF = 1e-2  # relative
KNOWN = {"gyroscope": (GYRO_UNITS, "deg/s", "--unit-gyro"), "accelerometer": (ACCEL_UNITS, "g", "--unit-accel")}


def unit_of_columns(told: str | None, names: Sequence[str | None], known: Mapping[str, float]) -> str | None:
    """Return the unit that was told, or that the names of a triad's columns have in common; None of neither."""
    if told is not None:
        return None if told == RAW else told
    found = {split_unit(name)[1] for name in names if name}
    return found.pop() if len(found) == 1 and found <= set(known) else None


def refuse_other_units(told: Told, document: Mapping[str, Any]) -> None:
    """Refuse rates whose columns are in a unit other than the calibration's outputs were.

    Raises
    ------
    DataRefused
        Naming the unit, and how many outputs 1 deg/s or 1 g is in the calibration.
    """
    for triad, unit in told.units:
        known, per, option = KNOWN[triad]
        outputs = outputs_per_unit(unit, known)
        if triad not in document or outputs is None:
            continue
        k = float(np.mean(np.abs(document[triad]["scale_factor"]["value"])))
        if not 1 / MAX_TIMES_OFF < k / outputs < MAX_TIMES_OFF:
            raise DataRefused(
                told.name, None, f"{triad} in {unit}, {outputs:.4g} outputs in 1 {per}",
                f"{k:.4g} outputs in 1 {per}, as in the calibration",
                f"convert the columns, or state {option} raw if their names are wrong",
            )  # fmt: skip


def refuse_other_rate(t: FloatArray, column: str, rate_hz: float, name: str) -> None:
    """Refuse ``--rate`` [1/s] where a column of times ``t`` (n,) [s] says otherwise by more than 1 %."""
    step = float(np.nanmedian(np.diff(t))) if len(t) > 1 else 0.0
    if step > 0 and abs(step * rate_hz - 1) > MAX_RATE_OFF:
        raise DataRefused(
            name, None, f"{1 / step:.6g} rows a second by column {column}", f"--rate {rate_hz:g} within 1 %",
            "omit --rate, or remove the column",
        )  # fmt: skip
