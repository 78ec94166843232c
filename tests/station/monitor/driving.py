"""A monitor of a simulated drive in memory: IMU and receiver on one truth, read at one clock, no waiting."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from types import UnionType
from typing import Any

import numpy as np

from drivers.mavlink.gnss_fixes import MavlinkDecoder
from drivers.simulated.companions.gnss_server import Autopilot
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.faults import TimedFault
from drivers.simulated.truth import Truth
from drivers.simulated.vehicle_track import VehicleTrack
from procedures.fusion.vision.camera_time import CameraTimeOffset
from procedures.gnss_records import AirData, GnssFix, TimeMark
from station.calibrated import InUse
from station.calibrated.calibration_choice import AppliedCalibration
from station.calibrated.output_frame import DEFAULT_AXES, body_axes
from station.files.mcap_files.gnss_file import FixWriter, Record
from station.locate.live_camera import LiveCamera
from station.monitor.locator_thread import locating
from station.monitor.monitor import Monitor, MonitorOptions
from station.monitor.recording import MonitorRecording
from station.monitor.view import MonitorView
from station.stream.live.live_feed import open_feed
from station.stream.stream_events import StreamState
from tests.station.monitor.sighted import CAMERA, Sight
from tests.station.monitor.unit import calibration_of
from tests.station.stream.live.bench_in_memory import Source


class Receiver:
    """An autopilot heard without a port, at the IMU's own time; as `station.stream.auxiliary.LiveCompanion`.

    What is read is told ``late_s`` [s] later, as by a reader on a busy machine.
    """

    def __init__(
        self, source: Source, autopilot: Autopilot, writer: FixWriter | None, late_s: Callable[[float], float],
        says: UnionType,
    ) -> None:  # fmt: skip
        self._source, self._autopilot, self._writer, self._late_s = source, autopilot, writer, late_s
        self._says = says
        self._decoder, self._records = MavlinkDecoder(), list[Record]()

    def advance(self) -> None:
        now = self._source.device.imu.time - self._late_s(self._source.device.imu.time)
        while self._heard < now:
            self._heard = min(self._heard + 0.02, now)
            stamp = round(self._heard * 1e9)
            for record in self._decoder.feed(self._autopilot.due(self._heard), stamp):
                if isinstance(record, self._says):
                    self._records.append(record)
                    if self._writer is not None:
                        self._writer.write(record)

    _heard = 0.0

    @property
    def up_to_ns(self) -> int:
        return round(self._heard * 1e9)

    def take(self, until_ns: int) -> Sequence[Record]:
        found = [record for record in self._records if record.host_ns <= until_ns]
        self._records = self._records[len(found) :]
        return found

    def stream(self) -> StreamState:
        return StreamState("GNSS simulated", 10.0, 0.0, 0, 0, 0, 0)

    def utc(self, host_ns: int) -> float | None:
        return None


class DriveRig:
    """`run` lets device time pass; ``lines`` are the views that a sink was told.

    With ``sees``, how late [s] images are read and between which times [s] there are none, a camera is there; its
    delay is ``specified`` or not. ``held_s`` [s] at a time is what images come later by: see `Sight`.
    ``lag_s`` [s] is by how much the receiver's reader lags; unless it ``gives_time`` the sender's clock is
    not told. Nothing ``locates`` where a file is recorded.
    """

    def __init__(
        self, truth: Truth, track: VehicleTrack, autopilot: AutopilotTruth, faults: Sequence[TimedFault] = (),
        lever_arm: tuple[float, ...] = (0.0, 0.0, 0.0), folder: Path | None = None, seed: int = 1,
        sees: tuple[float, tuple[float, float]] | None = None, specified: float | None = None,
        held_s: Callable[[float], float] = lambda t: 0.0,
        filters: tuple[str, ...] = ("joint",), aid: str = "gnss",
        lag_s: Callable[[float], float] = lambda t: 0.0, format: str = "counts", pps: bool = False,
        gives_time: bool = True, locates: bool = True,
    ) -> None:  # fmt: skip
        self.source = Source(truth, format=format, seed=seed, pps=pps)
        self.source.device.drive(track)
        self.feed = open_feed(self.source)
        self.feed.identify(truth.model, truth.serial)
        self.lines: list[MonitorView] = []
        applied = AppliedCalibration(calibration_of(truth), None, InUse("by hand"))
        C = body_axes(DEFAULT_AXES)
        self.sight = sight = None if sees is None else Sight(self.source, track, *sees, held_s)
        eye = (
            None
            if sight is None
            else LiveCamera(CAMERA, sight.follow, None if specified is None else CameraTimeOffset(specified, 0.0))
        )
        where = None
        if locates and folder is None:
            where = locating(self.feed, applied, C, lever_arm, ExitStack(), live=False, camera=eye)
        self.writer = None if folder is None else FixWriter(folder / "gnss_1.mcap")
        heard = Autopilot(truth, autopilot, faults, track, seed)
        says = GnssFix | TimeMark | AirData if gives_time else GnssFix | AirData
        receiver = Receiver(self.source, heard, self.writer, lag_s, says)
        recording = None if folder is None else MonitorRecording(folder, self.feed.wire)
        if recording is not None:
            recording.begin()
        self.monitor = Monitor(
            self.feed, applied, MonitorOptions(C=C, aid=aid, filters=filters, locating=where, camera=sight),
            recording,
            receiver, (self.lines.append,),
        )  # fmt: skip

    @property
    def view(self) -> MonitorView:
        return self.monitor.view

    def run(self, seconds: float) -> MonitorView:
        end = self.source.device.imu.time + seconds
        while self.source.device.imu.time < end:
            self.monitor.round()
        return self.view


@dataclass(frozen=True, slots=True, eq=False)
class DrivenAlong:
    """A drive that is over: all its views, the last one, and ``restarted`` that of a unit restarted.

    The window has images of the camera up to ``seen_until`` [s] and waits for those of so many keyframes. Without
    one they are nan and -1.
    """

    lines: list[MonitorView]
    view: MonitorView
    restarted: MonitorView
    seen_until: float
    awaited: int


def driven_along(
    seconds: float, track: VehicleTrack, autopilot: AutopilotTruth, truth: Truth, **options: Any
) -> DrivenAlong:
    """Drive for so long, by what `DriveRig` takes, and another second after the unit has restarted."""
    rig = DriveRig(truth, track, autopilot, **options)
    rig.run(seconds)
    lines, view = list(rig.lines), rig.view
    window = rig.monitor._options.locating._window  # noqa: SLF001
    is_seen = rig.sight is not None and window is not None
    of_images = (window.seen_until, window.awaited) if is_seen else (np.nan, -1)
    rig.feed.reset()
    return DrivenAlong(lines, view, rig.run(1.0), *of_images)


def record_drive(
    folder: Path, truth: Truth, track: VehicleTrack, autopilot: AutopilotTruth, seconds: float,
    filters: tuple[str, ...] = ("joint",),
) -> Path:  # fmt: skip
    """Record a drive as a monitored run leaves it, at once, and return the IMU's file."""
    folder.mkdir()
    rig = DriveRig(truth, track, autopilot, folder=folder, filters=filters)
    rig.run(seconds)
    rig.monitor.close()
    assert rig.writer is not None
    rig.writer.close()
    return folder / "recording.mcap"


def stands_on(track: VehicleTrack, location: Mapping[str, Any]) -> bool:
    """Say whether a location of `monitor/1` is where and which way a track goes: the fixes are good to a metre."""
    east, north, _ = track.velocity(location["t_s"])
    turned = location["heading_deg"] - np.degrees(np.arctan2(east, north))
    gone = track.position(location["t_s"]) - track.position(0.0)
    off = np.linalg.norm(np.array(location["enu_m"]) - gone)
    return bool(abs((turned + 180) % 360 - 180) < 4 * location["heading_std_deg"] and off < 2.5)
