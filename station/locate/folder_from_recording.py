"""A recording of IMU and GNSS as a fusion folder: calibrated, on the IMU's clock, level about the first fix."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from drivers.errors import ReplayEnded
from fixtures_db.folder_on_disk import make_folder
from procedures.fusion.fusion_records import GnssFixes, ImuSeries, antenna, is_usable, level_fixes, origin_at
from procedures.geodesy import LocalLevel, normal_gravity
from procedures.gnss_records import GnssFix, TimeMark
from station.calibrated.calibration_choice import AppliedCalibration, find_calibration
from station.calibrated.rates_and_forces import Sensors
from station.errors import DataRefused
from station.files.fusion_folder.fusion_writing import FusionRecording, WheelColumn, write_fusion
from station.files.mcap_files.gnss_file import Record
from station.locate.imu_source import MIN_REST_S, Rest, longest_rest, noise_densities
from station.locate.live_alignment import joined_series
from station.locate.monitor_interface import in_imu_axes
from station.stream.camera import recorded_tracks
from station.stream.gnss_fix_times import FixTimes
from station.stream.live.live_feed import LiveFeed, open_feed
from station.stream.live.stream_trouble import refuse_partial
from station.stream.recorder.sample_times import PulseAges
from station.stream.replay import Replay, read_recorded_fixes
from station.stream.wheel import recorded_speeds
from station.text import plural

BLOCK_S = 0.1
# s: of fixes placed by pulses at the IMU's input, by their sender's clock, and by when they were read
PULSED_STD, KNOWN_STD, UNKNOWN_STD = 0.002, 0.02, 0.1


@dataclass(frozen=True, slots=True, eq=False)
class FusionOptions:
    """How to make the folder: ``lever_arm`` (3,) [m], IMU to antenna in IMU axes, empty where not known."""

    calibration: Path | None = None
    database: str | None = None
    lever_arm: tuple[float, ...] = ()
    model: str = ""
    serial: str = ""


def fusion_from_recording(url: str, folder: Path, asked: FusionOptions) -> list[str]:
    """Write the fusion folder of a recorded MCAP file (``replay:FILE``), and return what was made of it, in lines.

    Raise `DataRefused` if the device does not measure six channels, there is no receiver's file next to it, no
    fix with a place in it, or neither calibration nor scale, and `CannotWrite` if the folder cannot be written.
    """
    feed, applied = _read(url, asked)
    refuse_partial(feed.address.name, feed.stream.decoder.kind)
    file = Path(feed.address.name)
    times, imu, sensors = FixTimes(), *_calibrated(feed, applied)
    buffer = feed.buffer
    marks = [(at, float(buffer.block(sample, sample + 1).device_time[0]))
             for at, sample in buffer.marks(buffer.begin, buffer.end)]  # fmt: skip
    for mark in marks:
        times.stamp_imu(*mark)
    for pulse_s in _pulses(feed):
        times.stamp_pulse(pulse_s)
    origin, fixes = _placed(file, read_recorded_fixes(file), times, imu)
    counts = sensors.quanta() if feed.wire.output == "increments" else (0.0, 0.0)
    rest = longest_rest(imu, counts[1])
    gravity = normal_gravity(origin.latitude, origin.height)
    noise = noise_densities(imu, rest, feed.period, applied.document, counts)
    std = PULSED_STD if times.all_by_pulse else KNOWN_STD if times.knows_sender else UNKNOWN_STD
    seen = recorded_tracks(file.parent, marks)
    make_folder(folder)
    rolled = recorded_speeds(file.parent, marks)
    wheel = None if rolled is None or not len(rolled[0].t) else WheelColumn(*rolled)
    made = FusionRecording(origin, gravity, imu, noise, fixes, std, asked.lever_arm, seen, wheel)
    write_fusion(folder, made)
    silent = [f"warning: {feed.silent}"] if feed.silent else []
    return [*silent, *_notes(folder, made, rest, applied)]


def _pulses(feed: LiveFeed) -> Iterator[float]:
    """Yield the times [s] of the pulses at the device's input, by its own clock."""
    if feed.wire.pulse is None:
        return
    pulses = PulseAges(feed.wire.pulse)
    for chunk, block in feed.buffer.recording([(feed.buffer.begin, feed.buffer.end)]):
        if (age := pulses.of(chunk.data, block)) is not None:
            yield float(block.device_time[-1]) - age


def _read(url: str, asked: FusionOptions) -> tuple[LiveFeed, AppliedCalibration]:
    """Return a feed that has taken the whole of a recording; what came before a restart is discarded."""
    feed = open_feed(Replay(url, 0.0))
    try:
        unit = feed.identify_or_unknown(asked.model, asked.serial)
        while True:
            feed.advance()
    except ReplayEnded:
        if feed.unit is None:
            raise
    return feed, find_calibration(asked.calibration, asked.database, unit, feed.wire)


def _calibrated(feed: LiveFeed, applied: AppliedCalibration) -> tuple[ImuSeries, Sensors]:
    """Return all samples in SI, stamped in the middle of their intervals, IMU axes."""
    counts = feed.wire.output == "increments"
    sensors = Sensors(applied.document, applied.nominal, np.eye(3), feed.period, counts=counts)
    buffer, size = feed.buffer, max(1, round(BLOCK_S / feed.period))
    blocks = (buffer.block(at, min(at + size, buffer.end)) for at in range(buffer.begin, buffer.end, size))
    parts = [in_imu_axes(sensors.take(block), np.eye(3), feed.period) for block in blocks]
    return joined_series(parts), sensors


def _placed(file: Path, records: list[Record], times: FixTimes, imu: ImuSeries) -> tuple[LocalLevel, GnssFixes]:
    """Return the usable fixes within the IMU's time, each a new one of the receiver's, level about the first."""
    for record in records:
        if isinstance(record, TimeMark):
            times.stamp_sender(record)
    fixes = [record for record in records if isinstance(record, GnssFix)]
    source = antenna(fixes)
    used, stamps = list[GnssFix](), list[float]()
    for fix in fixes:
        t = times.of(fix) if fix.source == source and is_usable(fix) else None
        if t is not None and imu.t[0] <= t <= imu.t[-1] and (not stamps or t > stamps[-1]):
            used.append(fix)
            stamps.append(t)
    if len(used) < 2:
        raise DataRefused(
            file, None,
            f"{plural(len(used), 'fix')} with a 3D position while the IMU was recorded",
            "two or more",
            "give the receiver a view of the sky; --gnss URL records it with the IMU",
        )  # fmt: skip
    origin = origin_at(used[0])
    return origin, level_fixes(origin, np.array(stamps), used)


def _notes(folder: Path, made: FusionRecording, rest: Rest, applied: AppliedCalibration) -> list[str]:
    imu, fixes, seen = made.imu, made.fixes, made.seen
    rested = f"noise from {rest.seconds:.0f} s of rest"
    if rest.seconds < MIN_REST_S:
        rested = f"warning: no rest of {MIN_REST_S:g} s was found, the noise is that of the quietest seconds"
    what = [f"{imu.t[-1] - imu.t[0]:.1f} s of IMU", plural(len(fixes.t), "fix")]
    what += [] if seen is None else [f"{plural(len(seen.tracks.frames()[0]), 'frame')} of the camera"]
    what += [] if made.wheel is None else [f"{plural(len(made.wheel.speeds.t), 'speed')} of the wheel"]
    return [
        f"{folder}: {', '.join(what)}, calibration {applied.in_use.text}",
        rested,
        f"station locate {folder}{'' if seen is None else ' --source vision'}",
    ]
