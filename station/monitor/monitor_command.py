"""`station monitor` put together: source, calibration, engine, and who looks at it."""

import sys
import tempfile
import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
import platformdirs

from drivers.address_parsing import parse_device_url
from drivers.camera import CameraImage
from drivers.can.frame_record import WheelReading
from procedures.arrays import FloatArray
from procedures.attitude.complementary_gains import ComplementaryGains
from procedures.attitude.filter_choice import JOINT, parse_filters, refuse_without_velocity
from procedures.geodesy import normal_gravity
from procedures.optional_libraries import opencv
from procedures.units import STANDARD_GRAVITY
from station.calibrated.calibration_choice import AppliedCalibration, find_calibration
from station.errors import DataRefused
from station.files.atomic_file import new_folder
from station.files.mcap_files.gnss_file import Record
from station.monitor.monitor import Monitor, MonitorOptions
from station.monitor.monitor_thread import MonitorThread
from station.monitor.recording import MonitorRecording
from station.monitor.text_lines import PlainMonitor, json_line, listen
from station.monitor.view import Alarm, MonitorSession, MonitorView
from station.stream.auxiliary import Companion, RecordedCompanion, read_late_messages
from station.stream.camera import (
    CAMERA_FILE,
    CAMERA_SESSION,
    CameraDescription,
    open_camera,
    read_description,
    recorded_images,
)
from station.stream.live.live_feed import ChunkSource, LiveFeed, RestartableReader, open_feed
from station.stream.live.stream_trouble import refuse_partial
from station.stream.recorder.sample_times import Utc
from station.stream.replay import Replay, is_mcap, recorded_choice, recorded_gnss
from station.stream.sample_rate import host_sample_rate
from station.stream.stream_events import EVENTS_FILE

if TYPE_CHECKING:
    from station.locate.live_locator import LiveLocator
    from station.monitor.locator_thread import LocatorThread
    from station.stream.gnss_feed import GnssFeed  # pymavlink: only where a receiver is read
    from station.stream.wheel import WheelDescription


def calibrated_output(
    to: Sequence[str], feed: LiveFeed, applied: AppliedCalibration, C: FloatArray, utc: Utc | None,
    recording: MonitorRecording | None, stack: ExitStack,
) -> Callable[[], None]:  # fmt: skip
    """Return what streams the samples that have come, nothing where ``to`` names no output; ``stack`` ends it.

    ``C`` (3, 3) takes IMU axes to forward-right-down. What it says stands among the events of the run; the end of
    it, what was lost and dropped, is on stderr too.

    Raises
    ------
    DataRefused
        If there is no calibration, or it is another unit's or of another output; the monitor alone would continue.
    """
    if not to:
        return lambda: None
    from station.calibrated.calibration_choice import refuse_unfit
    from station.sending.sender import FIT_S, opened_sender

    assert feed.unit is not None, "identify first"
    refuse_unfit(applied, "--calibration", feed.unit, feed.wire)
    wording = list[str]()

    def say(text: str) -> None:
        wording.append(text)
        del wording[:-1]
        if recording is not None:
            recording.note("stream", text, float("nan"), 0)

    rate = host_sample_rate(feed, FIT_S)
    sender = opened_sender(feed, applied, to, C, say, utc=utc, clock_off=lambda: rate.text)
    stack.callback(lambda: sys.stderr.writelines(f"{text}\n" for text in wording))
    stack.enter_context(sender)

    def take() -> None:
        rate.warned()
        sender.take()

    return take


WHEEL_FILE = "wheel.toml"  # of `station.stream.wheel`, which takes cantools
Output = Literal["screen", "plain", "json"]


@dataclass(frozen=True, slots=True, eq=False)
class MonitorRequest:
    """What the command line asks for, checked; angles in deg, ``gravity`` in m/s2."""

    url: str
    C: FloatArray
    aid: str = ""  # gnss with a receiver; in a replay as it was then
    filters: tuple[str, ...] = ()  # joint; in a replay as it was then
    tau_s: float | None = None  # of the complementary filters
    gnss: str = ""
    mavlink_out: str = ""
    stream: tuple[str, ...] = ()  # where calibrated samples go
    calibration: Path | None = None
    latitude_deg: float | None = None
    heading_deg: float | None = None
    gravity: float | None = None
    alarms: tuple[Alarm, ...] = ()
    locate: bool = False
    lever_arm: tuple[float, ...] = ()
    camera: Path | None = None  # its file
    wheel: Path | None = None  # its file
    folder: Path | None = None
    records: bool = True
    seconds: float = float("inf")
    speed: float = 1.0
    model: str = ""
    serial: str = ""
    database: str | None = None

    @property
    def replayed(self) -> Path | None:
        """The file that is replayed, None of a live device."""
        address = parse_device_url(self.url)
        return Path(address.path) if address.scheme == "replay" else None


def run(
    wanted: MonitorRequest, output: Output, show: Callable[[MonitorSession], None], *, quiet: bool = False
) -> None:
    """Monitor until the operator leaves, the replay or the time is over; raise what ended it otherwise.

    ``show`` is the screen: it returns when the operator has left.

    Raises
    ------
    DriverError, CannotWrite, DataRefused
        What port, disk or calibration refuse; nothing is left behind.
    """
    with ExitStack() as stack:
        monitor = _opened(wanted, (lambda view: _say(json_line(view)),) if output == "json" else (), stack)
        stays = output == "screen" and wanted.seconds == float("inf")
        session = stack.enter_context(MonitorThread(monitor, stays=stays, seconds=wanted.seconds))
        if output == "screen":
            show(session)
        else:
            _follow(session, plain=output == "plain", rings=not quiet)
    if session.failure is not None:
        raise session.failure


def _opened(wanted: MonitorRequest, sinks: tuple[Callable[[MonitorView], None], ...], stack: ExitStack) -> Monitor:
    """Return the engine of a device or a replay, with its folder."""
    file = _companion_file(wanted, wanted.camera, CAMERA_FILE)
    described = None if file is None else read_description(file)
    if described is not None:
        opencv()  # reported before anything is begun
    rolling = _wheel_described(wanted)
    filters, gains = _filters(wanted)
    folder = _folder(wanted, stack)
    work_folder = folder or Path(stack.enter_context(tempfile.TemporaryDirectory()))
    source, reader = _source(wanted, work_folder, stack)
    feed = open_feed(source)
    if reader is not None:
        reader.feed = feed
    unit = feed.identify_or_unknown(wanted.model, wanted.serial)
    refuse_partial(feed.address.name, feed.stream.decoder.kind)
    applied = find_calibration(wanted.calibration, wanted.database, unit, feed.wire)
    aid, aid_name = _aid(wanted, source, work_folder, stack)
    try:
        refuse_without_velocity(filters, aid_name)
    except ValueError as error:
        raise DataRefused(feed.address.name, None, str(error), "a recording that includes a receiver") from None
    camera = None if described is None else _camera(described, source, work_folder, stack)
    wheel = None if rolling is None else _wheel(rolling, source, work_folder, stack)
    where = _locating(wanted, feed, applied, aid, described, rolling, stack)
    if wanted.mavlink_out:
        sinks = (*sinks, _mavlink_out(wanted.mavlink_out, stack))
    utc = None if aid is None or isinstance(aid, RecordedCompanion) else aid.utc
    recording = None if folder is None else MonitorRecording(folder, feed.wire, utc)
    stream_out = calibrated_output(wanted.stream, feed, applied, wanted.C, utc, recording, stack)
    if recording is not None:
        how = {"begin": wanted.url, "aid": aid_name, "laws": ",".join(filters)}
        how |= {} if gains is None else {"gains": f"{gains.k1!r} {gains.k2!r}"}
        for event, text in how.items():
            recording.note(event, text, float("nan"), 0)
        if wanted.records:
            recording.begin()
    latitude = None if wanted.latitude_deg is None else float(np.radians(wanted.latitude_deg))
    return Monitor(
        feed, applied,
        MonitorOptions(
            aid=aid_name, filters=filters, gains=gains, C=wanted.C, latitude=latitude,
            heading=None if wanted.heading_deg is None else float(np.radians(wanted.heading_deg)),
            gravity=wanted.gravity or (STANDARD_GRAVITY if latitude is None else normal_gravity(latitude)),
            alarms=wanted.alarms, restart_reader=None if reader is None else reader.restart, locating=where,
            camera=camera, wheel=wheel, stream_out=stream_out,
        ),
        recording, aid, sinks, "" if folder is None else str(folder),
    )  # fmt: skip


def _folder(wanted: MonitorRequest, stack: ExitStack) -> Path | None:
    """Return the new folder of the run; None for a replay that asks for none."""
    folder = wanted.folder
    if folder is None:
        if wanted.replayed is not None:
            return None
        root = platformdirs.user_data_path("fog-station") / "monitor"
        folder = root / f"{datetime.now():%Y-%m-%d_%H%M%S}"
    return stack.enter_context(new_folder(folder, EVENTS_FILE))


def _aid(
    wanted: MonitorRequest, source: ChunkSource, work_folder: Path, stack: ExitStack
) -> tuple["GnssFeed | RecordedCompanion[Record] | None", str]:
    """Return the receiver, live or recorded, and by name what it aids with."""
    if isinstance(source, Replay) and not wanted.gnss:
        file = Path(source.address.name)
        found = recorded_gnss(file)
        if found is None and wanted.aid not in {"", "none"}:
            raise DataRefused(file, None, f"no gnss_*.mcap next to it, --aid {wanted.aid}", "a receiver")
        return found, wanted.aid or (recorded_choice(file, "aid") or "gnss" if found else "none")
    if not wanted.gnss:
        return None, wanted.aid or "none"
    from station.stream.gnss_feed import open_gnss

    return stack.enter_context(open_gnss(wanted.gnss, work_folder)), wanted.aid or "gnss"


def _filters(wanted: MonitorRequest) -> tuple[tuple[str, ...], ComplementaryGains | None]:
    """Return the filters and their gains, in a replay as they were unless others are asked for."""
    filters = wanted.filters
    gains = None if wanted.tau_s is None else ComplementaryGains.of_time_constant(wanted.tau_s)
    if (file := wanted.replayed) is not None:
        try:
            filters = filters or parse_filters(recorded_choice(file, "laws"))
            if gains is None and (text := recorded_choice(file, "gains")):
                gains = ComplementaryGains(*map(float, text.split()))
        except (ValueError, TypeError) as error:
            raise DataRefused(file.parent / EVENTS_FILE, None, str(error), "laws and gains of a run") from None
    return filters or (JOINT,), gains


def _locating(
    wanted: MonitorRequest, feed: LiveFeed, applied: AppliedCalibration,
    aid: "GnssFeed | RecordedCompanion[Record] | None", camera: CameraDescription | None,
    wheel: "WheelDescription | None", stack: ExitStack,
) -> "LiveLocator | LocatorThread | None":  # fmt: skip
    if not wanted.locate:
        return None
    from station.files.fusion_folder.fusion_tables import mount_of
    from station.locate.live_fixes import LiveWheel
    from station.monitor.locator_thread import live_camera, locating

    is_replay = isinstance(aid, RecordedCompanion)
    if aid is None:
        raise DataRefused(feed.address.name, None, "no gnss_*.mcap next to it for --locate", "a receiver")
    eye = None if camera is None else live_camera(camera)
    rolls = None if wheel is None else LiveWheel(mount_of(wheel.table), -wheel.table.time_offset_s)
    return locating(feed, applied, wanted.C, wanted.lever_arm, stack, live=not is_replay, camera=eye, wheel=rolls)


def _companion_file(wanted: MonitorRequest, named: Path | None, name: str) -> Path | None:
    """Return a companion's file that was named, or that a recording has; None where nothing is located by it."""
    if named is None and wanted.replayed is not None and (wanted.replayed.parent / name).exists():
        named = wanted.replayed.parent / name
    return named if wanted.locate else None


def _recorded_in(source: ChunkSource, session: str, what: str) -> Path | None:
    """Return the folder of a replay, None of a live source; refuse one that has none of a companion's files."""
    if not isinstance(source, Replay):
        return None
    recorded = Path(source.address.name).parent
    if not any(recorded.glob(f"{session}_*.mcap")):
        raise DataRefused(recorded, None, f"no {session}_*.mcap", what, "name another recording")
    return recorded


def _camera(
    described: CameraDescription, source: ChunkSource, work_folder: Path, stack: ExitStack
) -> Companion[CameraImage]:
    """Return the camera, live or recorded."""
    if (recorded := _recorded_in(source, CAMERA_SESSION, "the images of a camera")) is None:
        return stack.enter_context(open_camera(described, work_folder))
    return RecordedCompanion("camera", recorded_images(recorded), read_late_messages(recorded, "camera"))


def _wheel_described(wanted: MonitorRequest) -> "WheelDescription | None":
    if (file := _companion_file(wanted, wanted.wheel, WHEEL_FILE)) is None:
        return None
    from station.stream.wheel import described_in, read_description

    return read_description(file) if wanted.wheel is not None else described_in(file.parent)


def _wheel(
    described: "WheelDescription", source: ChunkSource, work_folder: Path, stack: ExitStack
) -> Companion[WheelReading]:
    """Return the wheel, live or recorded."""
    from station.stream.wheel import WHEEL_SESSION, open_wheel, recorded_wheel

    if (recorded := _recorded_in(source, WHEEL_SESSION, "the frames of a wheel")) is None:
        return stack.enter_context(open_wheel(described, work_folder))
    return RecordedCompanion("wheel", recorded_wheel(recorded, described), read_late_messages(recorded, "wheel"))


def _source(
    wanted: MonitorRequest, folder: Path, stack: ExitStack
) -> tuple[ChunkSource, RestartableReader | None]:
    if wanted.replayed is not None and is_mcap(wanted.replayed):
        return Replay(wanted.url, wanted.speed), None
    reader = RestartableReader(wanted.url, folder)
    stack.callback(reader.close)
    return reader.reader, reader


def _mavlink_out(where: str, stack: ExitStack) -> Callable[[MonitorView], None]:
    """Return a sink that reports each attitude by MAVLink."""
    from drivers.mavlink.imu_out import open_imu_out

    out = open_imu_out(where)
    stack.callback(out.close)

    def send(view: MonitorView) -> None:
        reading = view.reading
        assert reading is not None
        p, q, r = np.radians(reading.rate).tolist()
        yaw = np.nan if reading.heading is None else np.radians(reading.heading)
        out.attitude(reading.t, np.radians(reading.roll), np.radians(reading.pitch), (p, q, r), float(yaw))

    return send


def _follow(session: MonitorThread, *, plain: bool, rings: bool) -> None:
    """Write lines, if it is to be plain, and take keys, until it is over."""
    screen = PlainMonitor(_say, rings=rings)
    if plain:
        threading.Thread(target=listen, args=(session, sys.stdin, _say), daemon=True).start()
    while not session.view.is_over:
        session.changed.wait(1.0)
        session.changed.clear()
        if plain:
            screen.show(session.view)


def _say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()
