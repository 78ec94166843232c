"""A step's MCAP file as the columns that a CSV file of the same step would have."""

from io import BufferedReader
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray
from station.errors import DataRefused
from station.files.columns import MAX_EXACT_INTEGER, TRIADS, DataFile
from station.files.mcap_files.reader import read_stream
from station.files.mcap_files.schemas import COUNTS, COUNTS_TOPIC


def read_table(stream: BufferedReader, file: Path, *, counts: bool) -> DataFile:
    """Read a step's file as columns; a line of the table is a message of ``/imu/counts``.

    Raises
    ------
    DataRefused
        If the file is damaged, holds no sample, or rates where counts are said, or the other way round.
    """
    step = read_stream(stream, file)
    if not len(step):
        raise DataRefused(file, None, f"no message on {COUNTS_TOPIC}", "one message per sample")
    if (step.output == COUNTS) != counts:
        raise DataRefused(
            file, None, f"{step.output} messages", f"messages as imu.output says: counts is {counts}"
        )
    columns: dict[str, FloatArray] = {"t_s": step.device_ns / 1e9}
    for triad, names in TRIADS.items():
        values = getattr(step, triad)
        if values is not None:
            _check_range(values, file, triad, counts=counts)
            columns |= {name: values[:, i].astype(float) for i, name in enumerate(names)}
    if len(columns) == 1:
        raise DataRefused(file, 1, "neither gyro nor accel", "at least one triad")
    columns["temp_c"] = np.where(np.isfinite(step.temperature), step.temperature, np.nan)
    for name, values in step.aux.items():
        columns[name if name == "utc_s" or name.startswith("aux_") else f"aux_{name}"] = values
    first, last = int(step.host_ns.min()), int(step.host_ns.max())
    return DataFile(str(file), columns, 1, step.sha256, (first, last) if first > 0 else None, step.damage)


def _check_range(values: FloatArray, file: Path, triad: str, *, counts: bool) -> None:
    bad = (values >= MAX_EXACT_INTEGER) | (values <= -MAX_EXACT_INTEGER) if counts else ~np.isfinite(values)
    if len(rows := np.flatnonzero(bad.any(axis=1))):
        wanted = "counts below 2^53" if counts else "finite numbers"
        raise DataRefused(file, int(rows[0]) + 1, f"{triad} {values[rows[0]].tolist()}", wanted)
