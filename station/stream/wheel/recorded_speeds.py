"""The wheel of a recording as speeds on the IMU's clock."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from procedures.fusion.wheel_speeds import WheelSpeeds
from station.files.fusion_folder.fusion_schema import WheelMountTable
from station.stream.gnss.fix_times import FixTimes
from station.stream.wheel.description import DBC_FILE, WHEEL_FILE, WheelDescription, read_description
from station.stream.wheel.wheel_feed import recorded_wheel


def described_in(folder: Path) -> WheelDescription | None:
    """Return the wheel beside a recording, by the DBC that was kept there; None where there was none."""
    if not (folder / WHEEL_FILE).exists():
        return None
    return read_description(folder / WHEEL_FILE, folder / DBC_FILE)


def recorded_speeds(
    folder: Path, marks: Iterable[tuple[int, float]]
) -> tuple[WheelSpeeds, WheelMountTable] | None:
    """Return what the wheel beside a recording told, and how it stands to the IMU; None where there was none.

    ``marks`` are moments of reading [ns] and the device times [s] of the samples that came then.

    Raises
    ------
    DataRefused, BadCanFile
        If the wheel's file, its DBC or its bytes are damaged.
    """
    if (described := described_in(folder)) is None:
        return None
    times = FixTimes()
    for host_ns, device_s in marks:
        times.mark_imu(host_ns, device_s)
    told = [(times.of(each), each.speed) for each in recorded_wheel(folder, described)]
    rows = np.array([(t, speed) for t, speed in told if t is not None]).reshape(-1, 2)
    rows[:, 0] += described.table.time_offset_s
    rows = rows[np.r_[True, np.diff(np.maximum.accumulate(rows[:, 0])) > 0]] if len(rows) else rows
    return WheelSpeeds(rows[:, 0], rows[:, 1]), described.table
