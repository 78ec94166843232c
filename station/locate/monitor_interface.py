"""What a monitor passes to a locator and receives from it."""

from collections.abc import Sequence
from dataclasses import dataclass

from drivers.camera import CameraImage
from drivers.can.frame_record import WheelReading
from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import ImuSeries
from station.calibrated.rates_and_forces import CalibratedTick
from station.files.mcap_files.gnss_file import Record
from station.locate.location import Location
from station.stream.stream_events import Sound


@dataclass(frozen=True, slots=True, eq=False)
class LocatorTick:
    """A tenth of a second: samples in SI, IMU axes; ``marks`` of reading [ns] and their device times [s]."""

    imu: ImuSeries
    marks: Sequence[tuple[int, float]]
    records: Sequence[Record]
    images: Sequence[CameraImage] = ()
    wheel: Sequence[WheelReading] = ()
    pulses: Sequence[float] = ()  # device times [s] of a pulse a second at the IMU's input
    images_dropped: int = 0  # omitted, so that the locator keeps up


def in_imu_axes(tick: CalibratedTick, C: FloatArray, period: float) -> ImuSeries:
    """Return a tick's samples, in mid-interval; the rotation ``C`` (3, 3) takes IMU axes to the body's."""
    return ImuSeries(tick.t - period / 2, tick.calibrated.rate @ C, tick.calibrated.force @ C)


def location_event(before: Location | None, found: Location) -> tuple[Sound, str] | None:
    """Return what is to be reported of a location, and how it sounds."""
    if found.images_dropped and not (before is not None and before.images_dropped):
        return "rejected", "images arrive too late and are dropped: position and heading continue without them"
    was = before is not None and before.is_located
    if found.is_located and not was:
        return "accepted", "position and heading are known"
    if was and not found.is_located:
        return "rejected", f"position and heading are no longer known: {found.why}"
    return None
