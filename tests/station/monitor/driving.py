"""A monitor of a simulated drive in memory: IMU and receiver on one truth, read at one clock, no waiting."""

from collections.abc import Sequence
from contextlib import ExitStack

from drivers.mavlink.decoder import MavlinkDecoder
from drivers.simulated.autopilot import Autopilot
from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.gnss_faults import GnssFault
from drivers.simulated.track import Track
from drivers.simulated.truth import Truth
from procedures.gnss import AirData, GnssFix, TimeMark
from station.live import open_feed
from station.mcap_files.fix_reader import Record
from station.monitor.body_axes import DEFAULT, body_axes
from station.monitor.calibration import Applied
from station.monitor.locating import locating
from station.monitor.monitor import Monitor, Options
from station.monitor.view import InUse, Stream, View
from tests.station.live.bench_in_memory import Source
from tests.station.monitor.unit import calibration_of


class Receiver:
    """An autopilot heard without a port, at the IMU's own time; `station.monitor.monitor.Aid`."""

    def __init__(self, source: Source, autopilot: Autopilot) -> None:
        self._source, self._autopilot = source, autopilot
        self._decoder, self._records = MavlinkDecoder(), list[Record]()

    def advance(self) -> None:
        now = self._source.device.imu.time
        while self._heard < now:
            self._heard = min(self._heard + 0.02, now)
            stamp = round(self._heard * 1e9)
            self._records += [
                record
                for record in self._decoder.feed(self._autopilot.due(self._heard), stamp)
                if isinstance(record, GnssFix | TimeMark | AirData)
            ]

    _heard = 0.0

    @property
    def up_to_ns(self) -> int:
        return round(self._heard * 1e9)

    def take(self, until_ns: int) -> Sequence[Record]:
        found = [record for record in self._records if record.host_ns <= until_ns]
        self._records = self._records[len(found) :]
        return found

    def stream(self) -> Stream:
        return Stream("GNSS simulated", 10.0, 0.0, 0, 0, 0, 0)

    def utc(self, host_ns: int) -> float | None:
        return None


class DriveRig:
    """`run` lets device time pass; ``lines`` are the views that a sink was told."""

    def __init__(
        self, truth: Truth, track: Track, autopilot: AutopilotTruth, faults: Sequence[GnssFault] = (),
        lever_arm: tuple[float, ...] = (0.0, 0.0, 0.0),
    ) -> None:  # fmt: skip
        self.source = Source(truth)
        self.source.device.drive(track)
        self.feed = open_feed(self.source)
        self.feed.identify()
        self.lines: list[View] = []
        applied = Applied(calibration_of(truth), None, InUse("by hand", 1.0))
        C = body_axes(DEFAULT)
        where = locating(self.feed, applied, C, lever_arm, ExitStack(), live=False)
        receiver = Receiver(self.source, Autopilot(truth, autopilot, faults, track, 1))
        self.monitor = Monitor(
            self.feed, applied, Options(C=C, aid="gnss", locating=where), None, receiver, (self.lines.append,)
        )

    @property
    def view(self) -> View:
        return self.monitor.view

    def run(self, seconds: float) -> View:
        end = self.source.device.imu.time + seconds
        while self.source.device.imu.time < end:
            self.monitor.round()
        return self.view
