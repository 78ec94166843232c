"""What a live locator is told at a time."""

from collections.abc import Sequence
from dataclasses import dataclass

from drivers.camera import CameraImage
from procedures.fusion.fusion_records import ImuSeries
from station.files.mcap_files.fix_reader import Record


@dataclass(frozen=True, slots=True, eq=False)
class LocatorTick:
    """A tenth of a second: samples in SI, IMU axes; ``marks`` of reading [ns] and their device times [s]."""

    imu: ImuSeries
    marks: Sequence[tuple[int, float]]
    records: Sequence[Record]
    images: Sequence[CameraImage] = ()
