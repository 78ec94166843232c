"""The engine: a live feed to attitude, tick by tick, and everything a screen shows of it."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from drivers.camera import CameraImage
from drivers.can.frame_record import WheelReading
from drivers.errors import DriverError, LinkLost, ReplayEnded
from procedures.arrays import FloatArray
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_gains import ComplementaryGains
from procedures.attitude.filter_choice import JOINT
from procedures.attitude.kalman.kalman_settings import KalmanSettings
from procedures.attitude.kalman.unaided_motion import heading_at_rest
from procedures.units import STANDARD_GRAVITY
from station.attitude.error_at_rest import ErrorAtRest
from station.attitude.live_filters import LiveFilters
from station.attitude.live_kalman_filter import AidValues, AttitudeEstimator
from station.attitude.live_readings import AttitudeReading, FilterReading, difference
from station.calibrated import InUse
from station.calibrated.calibration_choice import AppliedCalibration
from station.calibrated.filter_settings import filter_settings, gyro_bias_std, in_a_vehicle
from station.calibrated.rates_and_forces import CalibratedTick, Sensors
from station.files.mcap_files.gnss_file import Record
from station.locate.location import Location
from station.locate.monitor_interface import LocatorTick, in_imu_axes, location_event
from station.monitor.auxiliary_inputs import AidSilence, AuxiliaryReaders, StreamHealth, aiding_of
from station.monitor.recording import MonitorRecording
from station.monitor.view import Alarm, AlarmWatch, ChartPoint, MonitorVerb, MonitorView
from station.stream.auxiliary import Companion
from station.stream.live.live_feed import LiveFeed
from station.stream.live.stream_trouble import without_numbers
from station.stream.recorder.sample_times import SampleMoments
from station.stream.stream_events import EventLog, Sound

if TYPE_CHECKING:  # graphs and their libraries: only where it is located
    from station.locate.live_locator import LiveLocator
    from station.monitor.locator_thread import LocatorThread

TICK_S = 0.1
VEHICLE_WARNING = (
    "it moves like a vehicle without velocity aid: the attitude relies on the gyros, its uncertainty is large; "
    "use --gnss"
)
HISTORY = 600  # points: a minute


@dataclass(frozen=True, slots=True, eq=False)
class MonitorOptions:
    """How to monitor: ``aid`` by name, ``C`` (3, 3) IMU axes to forward-right-down; angles in rad, m/s2.

    ``speed`` [m/s] of the aid is shown; latitude and ``heading`` of forward are None where not known.
    """

    aid: str = "none"
    filters: tuple[str, ...] = (JOINT,)
    gains: ComplementaryGains | None = None  # of the complementary filters; those printed where None
    C: FloatArray | None = None
    latitude: float | None = None
    heading: float | None = None
    gravity: float = STANDARD_GRAVITY
    alarms: tuple[Alarm, ...] = ()
    stream_out: Callable[[], None] = lambda: None  # what has come, before it is discarded
    restart_reader: Callable[[], None] | None = None  # has a reader that ended begin again
    locating: "LiveLocator | LocatorThread | None" = None
    camera: Companion[CameraImage] | None = None  # whose images ``locating`` receives
    wheel: Companion[WheelReading] | None = None  # as well


class Monitor:
    """Follows one unit; call `round` for ever. ``sinks`` receive each reading."""

    def __init__(
        self, feed: LiveFeed, applied: AppliedCalibration, options: MonitorOptions,
        recording: MonitorRecording | None = None, aid: Companion[Record] | None = None,
        sinks: tuple[Callable[[MonitorView], None], ...] = (), folder: str = "",
    ) -> None:  # fmt: skip
        self._feed, self._options, self._recording = feed, options, recording
        self._sinks, self._in_use = sinks, applied.in_use
        self._auxiliary = AuxiliaryReaders(aid, options.camera, options.wheel)
        if recording is not None:
            self._auxiliary.note_late_messages = recording.note_late_messages
        heading = np.nan if options.heading is None else options.heading
        C = self._C = np.diag([1.0, -1.0, -1.0]) if options.C is None else options.C
        counts = feed.wire.output == "increments"
        self._sensors = Sensors(applied.document, applied.nominal, C, feed.period, counts=counts)
        self._applied = applied
        self._silence = AidSilence(options.aid)
        can_compass = options.latitude is not None and options.heading is None and applied.document is not None
        is_vehicle = partial(in_a_vehicle, calibration=applied.document)
        compass = self._compass if can_compass else None
        self._track = AttitudeEstimator(options.aid, self._settings, heading, compass, is_vehicle)
        self._filters = LiveFilters(
            options.filters, options.aid, self._track, applied.document, options.gravity, options.gains
        )
        self._reported: dict[str, str] = {}  # what was said last, by what it is about
        self._rest = ErrorAtRest(options.gravity, options.latitude, options.heading, self._sensors.quantum(TICK_S))
        self._watch, self._health = AlarmWatch(options.alarms), StreamHealth(feed)
        self._size = max(1, round(TICK_S / feed.period))
        self._at = self._begin = self._noted = feed.buffer.first
        self._history: deque[ChartPoint] = deque(maxlen=HISTORY)
        self._event_log, self._marks = EventLog(), 0
        self._speed: float | None = None
        self._moments = SampleMoments()
        unit = feed.unit
        self.view = MonitorView(
            unit=f"{unit.model} {unit.serial}" if unit else "", aid=options.aid, in_use=self._in_use, folder=folder
        )

    def round(self) -> None:
        """Take what has come, waiting for it a moment.

        Raises
        ------
        ReplayEnded
            At a replay's end, all before it taken.
        CannotWrite
            If the disk refuses.
        """
        try:
            self._feed.advance()
            if self._feed.lost:
                raise LinkLost(self._feed.address.name, "unplugged; plug it in again")
            self._is_well("")
        except ReplayEnded:
            raise
        except DriverError as error:
            self._is_well(str(error))
            if self._options.restart_reader is not None:
                self._options.restart_reader()
        self._options.stream_out()
        self._auxiliary.advance()
        self._take()
        self._show()

    def execute(self, verb: MonitorVerb) -> None:
        """Do as the operator says; raise `CannotWrite` if the disk refuses."""
        if verb == "mark":
            self._marks += 1
            self._say("start", "mark", f"mark {self._marks}")
        elif verb == "zero":
            self._zero()
        elif verb == "restart":
            self._history.clear()
            self._rest.reset()
            self._say("", "restart", "charts and comparison restarted")
        elif verb == "record":
            self._record()
        self._show()

    def at_end(self) -> None:
        """Say that a replay is over."""
        self._say("", "end", "end of the replay")
        self._show()

    def close(self) -> None:
        """Finish what is being recorded."""
        if self._recording is not None:
            self._recording.end()
        self._change(is_over=True, recording="", line="ended")

    def _settings(self, log: AttitudeLog, knows_heading: bool) -> KalmanSettings:
        options, quantum = self._options, self._sensors.quantum(self._feed.period)
        bench = options.gravity, options.latitude
        return filter_settings(self._applied.document, options.aid, log, *bench, knows_heading, quantum)

    def _compass(self, log: AttitudeLog) -> tuple[float, float] | None:
        """Return what a rest's gyros say of the heading [rad]."""
        assert self._options.latitude is not None
        assert self._applied.document is not None
        return heading_at_rest(log, self._options.latitude, gyro_bias_std(self._applied.document))

    def _report_attitude(self, filters: Sequence[FilterReading]) -> None:
        """Say once that north is known, that it moves like a vehicle, and what is against a filter."""
        if self._track.north is not None and "north" not in self._reported:
            heading, std = np.degrees(self._track.north)
            text = self._reported["north"] = f"heading {heading % 360:.1f} deg, u = {std:.1f}"
            self._say("accepted", "north", f"north from the Earth's rate: {text}")
        notes = {f"note {reading.name}": reading.note for reading in filters}
        if self._track.is_vehicle:
            notes["vehicle"] = VEHICLE_WARNING
        for about, text in notes.items():
            if text and text != self._reported.get(about):
                self._say("rejected", "vehicle" if about == "vehicle" else "law", text)
            self._reported[about] = text

    def _report_trouble(self, event: str, about: str, trouble: str, well: str) -> None:
        """Say what is wrong as it appears, not again for each new figure, and when it is over."""
        if (words := without_numbers(trouble)) != self._reported.get(about, ""):
            self._reported[about] = words
            self._say("rejected" if words else "accepted", event, trouble or well)

    def _zero(self) -> None:
        reading = self.view.reading
        if self.view.zero is not None:
            self._change(zero=None)
            self._say("", "zero", "zero removed: angles are absolute")
        elif reading is not None:
            self._change(zero=(reading.roll, reading.pitch))
            self._say("", "zero", f"zero at roll {reading.roll:.3f}, pitch {reading.pitch:.3f} deg (display only)")

    def _record(self) -> None:
        if self._recording is None:
            self._say("rejected", "record", "no folder to record into: give --folder")
        elif self._recording.name:
            self._say("accepted", "record", f"{self._recording.end()} is complete")
        else:
            self._say("start", "record", f"recording into {self._recording.begin()}")

    def _take(self) -> None:
        """Advance by every whole tick; a restart discards the incomplete one."""
        buffer = self._feed.buffer
        if buffer.begin != self._begin:
            self._at, self._begin = buffer.begin, buffer.begin
            self._filters.reset()
            self._moments.reset()
            self._rest.reset()
            if self._options.locating is not None:
                self._options.locating.reset()
        if self._recording is not None:
            self._recording.take(
                buffer, max(self._noted, buffer.first), buffer.end, self._feed.stream.decoder.kind
            )
            self._noted = buffer.end
        while buffer.end - self._at >= self._size:
            first, last = self._at, self._at + self._size - 1
            if not self._auxiliary.has_everything(buffer.host_ns(last)):
                break
            self._at += self._size
            tick = self._sensors.take(buffer.block(first, self._at))
            now_ns = self._moments.of(float(tick.t[-1]), buffer.host_ns(last))
            data = self._auxiliary.take(now_ns)
            if self._options.locating is not None:
                marks = [(at, float(tick.t[sample - first])) for at, sample in buffer.marks(first, self._at)]
                imu = in_imu_axes(tick, self._C, self._feed.period)
                pulses = self._feed.pulses(float(tick.t[-1]))
                self._options.locating.take(LocatorTick(imu, marks, data.records, data.images, data.wheel, pulses))
            self._go_on(tick, data.records, now_ns)
        buffer.forget_before(self._at)

    def _go_on(self, tick: CalibratedTick, records: Sequence[Record], now_ns: int) -> None:
        aiding = aiding_of(records, self._options.aid, now_ns)
        self._learn_speed(aiding)
        self._health.unhealthy += not tick.is_healthy
        if tick.not_applied and not self._in_use.note:
            self._in_use = InUse(self._in_use.text, "not corrected: " + "; ".join(tick.not_applied))
        if text := self._silence.look(aiding, float(tick.t[-1])):
            self._say("rejected", "aid silent", text)
        read = self._filters.take(tick.t, tick.calibrated, aiding)
        if read is None:
            self._change(line="keep it still for 2 s: measuring the noise")
            return
        found, filters = read
        self._rest.take(tick, TICK_S, rests=found.mode == "at rest")
        temperature = tick.temperature if np.isfinite(tick.temperature) else None
        reading = replace(found, speed=self._speed, temperature=temperature, sample=self._at - 1)
        self._change(
            reading=reading, filters=filters, at_rest=self._rest.comparison, line="", location=self._location()
        )
        speed = np.nan if self._speed is None else self._speed
        point = reading.t, reading.roll, reading.pitch, *reading.rate, speed, reading.residual, reading.sigma
        apart = difference(filters)
        self._history.append(ChartPoint(*point, np.nan if apart is None else apart.angle))
        self._report_attitude(filters)
        self._ring(reading)
        if self._recording is not None:
            self._recording.take_filters(self.view)
        for sink in self._sinks:
            sink(self.view)

    def _location(self) -> Location | None:
        """Return where the unit is, if that is asked for; what is new about it is reported once."""
        if self._options.locating is None:
            return None
        found = self._options.locating.location
        if (news := location_event(self.view.location, found)) is not None:
            self._say(news[0], "location", news[1])
        return found

    def _learn_speed(self, aiding: AidValues) -> None:
        if np.isfinite(aiding.airspeed):
            self._speed = float(aiding.airspeed)
        elif np.isfinite(aiding.velocity[0]):
            self._speed = float(np.hypot(*aiding.velocity[:2]))

    def _ring(self, reading: AttitudeReading) -> None:
        begun, ended = self._watch.look(reading)
        for text in begun:
            self._say("rejected", "alarm", f"ALARM {text}")
        for text in ended:
            self._say("", "alarm over", text)
        silent = self._feed.silent
        self._report_trouble("channel", "channels", silent, "all channels work again")
        self._change(alarms=(*self._watch.on.values(), *([silent] if silent else [])))

    def _is_well(self, trouble: str) -> None:
        if trouble != self._health.trouble:
            self._health.trouble = trouble
            self._say("rejected" if trouble else "accepted", "stream", trouble or "data arrive again")

    def _say(self, sound: Sound, event: str, text: str) -> None:
        self._event_log.say(sound, text)
        if self._recording is not None:
            reading = self.view.reading
            self._recording.note(event, text, reading.t if reading else float("nan"), self._at - 1)

    def _show(self) -> None:
        streams = (self._health.look(), *self._auxiliary.streams())
        for each in streams[1:]:
            self._report_trouble("stream", each.name, each.trouble, f"{each.name}: well again")
        recording = self._recording.name if self._recording is not None else ""
        self._change(
            streams=streams, at_rest=self._rest.comparison, history=tuple(self._history),
            events=self._event_log.events, recording=recording, in_use=self._in_use,
        )  # fmt: skip

    def _change(self, **changes: object) -> None:
        self.view = replace(self.view, **changes)  # type: ignore[arg-type]
