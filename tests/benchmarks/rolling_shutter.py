"""A rolling shutter, its row time told and not: ``python -m tests.benchmarks.rolling_shutter DATA [--seeds N]``.

Real IMU and truth of DATA/v102_tracks; GNSS and tracks are drawn anew for each seed, the tracks row by row. Errors
are as of `tests.benchmarks.locate`.
"""

import argparse
from dataclasses import replace
from pathlib import Path

from procedures.fusion.vision.feature_tracks import PinholeCamera
from station.files.fusion_folder import FusionLog, read_fusion
from station.locate.camera_source import by_vision
from tests.benchmarks.locate import HEADS, drawn, row, said
from tests.benchmarks.locate_vision import CAMERA
from tests.drivers.simulated.camera_tracks import View, simulate_tracks

ROW_TIMES = (30e-6, 60e-6)  # s: 14 and 29 ms an image of 480 rows
NAME = "v102_tracks"


def seen(data: Path, seed: int, row_time: float, told: float) -> FusionLog:
    """Return a folder whose camera takes a row each ``row_time`` [s], and is ``told`` to."""
    log = drawn(read_fusion(data / NAME), seed)
    assert log.truth is not None
    taken: PinholeCamera = replace(CAMERA, row_time=row_time)
    return replace(
        log, tracks=simulate_tracks(log.truth, taken, View(), seed), camera=replace(CAMERA, row_time=told)
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("--seeds", type=int, default=3)
    asked = parser.parse_args()
    for row_time, told in [(0.0, 0.0), *((each, told) for each in ROW_TIMES for told in (each, 0.0))]:
        rows = [row(log := seen(asked.data, seed, row_time, told), by_vision(log)) for seed in range(asked.seeds)]
        said(f"a row each {row_time * 1e6:.0f} us, told {told * 1e6:.0f} us", rows, HEADS)
