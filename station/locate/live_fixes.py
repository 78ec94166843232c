"""Fixes and wheel speeds of a live run on the IMU's clock, and the report of a live location.

Fixes are level about the first; each one asks for a keyframe. The report has place, heading, their uncertainties,
the distance covered, and which fixes are outliers.
"""

from collections import deque
from collections.abc import Iterable, Sequence

import numpy as np

from drivers.can.frame_record import WheelReading
from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import (
    GnssFixes,
    ImuNoise,
    WheelMount,
    WheelSpeeds,
    antenna,
    is_usable,
    level_fixes,
    no_speeds,
    origin_at,
)
from procedures.fusion.inner.inner_window import InnerWindow
from procedures.fusion.inner.wheel_aid import WheelAid
from procedures.fusion.inner.window_state import KEYFRAME_SPACING_S, MIN_FIX_SPACING_S
from procedures.fusion.pose_graph import OUTLIER_SIGMAS, GlobalPose
from procedures.geodesy import LocalLevel
from procedures.gnss_records import GnssFix, TimeMark
from station.files.mcap_files.gnss_file import Record
from station.locate.location import Location
from station.stream.gnss_fix_times import FixTimes

STAMPS_NS = 60 * 10**9  # of the lines between the clocks
KEYFRAME_DELAY_S = (0.1, 1.0)  # s: how far behind the newest sample keyframes may stand
EARLY_S = 0.06  # by which a fix is to be known before a keyframe comes near it
AGE_FIXES = 20  # fixes, whose lateness is looked at
STRANGE_S = 5.0  # from the newest sample, beyond which a fix's time is none
MAX_TAKEN_FIXES, KEPT_TAKEN_FIXES = 2000, 1000  # fixes that are kept once they are taken


class LiveFixes:
    """``origin``: where the first fix stood; ``fixes``: those kept of ``count``; ``taken`` lie behind."""

    def __init__(self, origin: LocalLevel | None = None) -> None:
        self.origin = origin
        self.fixes: GnssFixes | None = None
        self.taken = self.count = 0
        self._times = FixTimes(STAMPS_NS)
        self._source = ""
        self._ages: deque[float] = deque(maxlen=AGE_FIXES)

    def mark(self, marks: Iterable[tuple[int, float]], pulses: Iterable[float] = ()) -> None:
        """Take moments of reading [ns] with the device times [s] of the samples that came then, and of pulses."""
        for host_ns, device_s in marks:
            self._times.stamp_imu(host_ns, device_s)
        for device_s in pulses:
            self._times.stamp_pulse(device_s)

    def take(self, records: Sequence[Record], now: float) -> GnssFixes | None:
        """Return what is new among records, None where nothing is; ``now`` [s] is the newest sample's time."""
        before = 0 if self.fixes is None else len(self.fixes.t)
        for record in records:
            if isinstance(record, TimeMark):
                self._times.stamp_sender(record)
            elif isinstance(record, GnssFix) and is_usable(record):
                self._source = self._source or antenna([record])
                t = self._times.of(record) if record.source == self._source else None
                if t is not None and abs(now - t) < STRANGE_S and (self.fixes is None or t > self.fixes.t[-1]):
                    self._place(record, t, now)
        return None if self.fixes is None or len(self.fixes.t) == before else self.fixes.part(slice(before, None))

    def _place(self, fix: GnssFix, t: float, now: float) -> None:
        self.origin = self.origin or origin_at(fix)
        self._ages.append(now - t)
        new = level_fixes(self.origin, np.array([t]), [fix])
        self.fixes = new if self.fixes is None else self.fixes.followed_by(new)
        self.count += 1

    @property
    def lateness(self) -> float:
        """How far behind the newest sample [s] keyframes are to stand."""
        return float(np.clip(max(self._ages, default=0.0) + EARLY_S, *KEYFRAME_DELAY_S))

    @property
    def newest_taken(self) -> float:
        """The time [s] of the newest fix that has its keyframe."""
        assert self.fixes is not None
        return float(self.fixes.t[max(self.taken - 1, 0)])

    @property
    def std(self) -> float:
        """1 sigma [m] of each axis of that fix, as the receiver says."""
        assert self.fixes is not None
        return float(self.fixes.position_std[max(self.taken - 1, 0)])

    def forget(self) -> None:
        """Let old fixes go that have their keyframes."""
        if self.fixes is not None and self.taken > MAX_TAKEN_FIXES:
            self.fixes, self.taken = self.fixes.part(slice(KEPT_TAKEN_FIXES, None)), self.taken - KEPT_TAKEN_FIXES

    def next_keyframe(self, last: float, until: float) -> float | None:
        """Return the time of the keyframe after ``last`` [s]; None if it is after ``until``.

        Keyframes stand at fixes, and between them evenly, at most `KEYFRAME_SPACING_S` apart.
        """
        assert self.fixes is not None
        t, k = self.fixes.t, self.taken
        while k < len(t) and t[k] < last + MIN_FIX_SPACING_S:
            k += 1  # on the heels of a keyframe, or too late
        if k < len(t) and (gap := float(t[k]) - last) < 2 * KEYFRAME_SPACING_S + MIN_FIX_SPACING_S:
            parts = max(1, int(np.ceil(gap / KEYFRAME_SPACING_S - 0.5)))
            at = float(t[k]) if parts == 1 else last + gap / parts
        else:
            at = last + KEYFRAME_SPACING_S
        return None if at > until else at

    def passed(self, t: float) -> range:
        """Return which fixes a keyframe at ``t`` [s] leaves behind that none has before."""
        assert self.fixes is not None
        first, self.taken = self.taken, max(self.taken, int(np.searchsorted(self.fixes.t, t, "right")))
        return range(first, self.taken)


SILENT_S = 2.0
KEPT_S = 300.0  # of speeds, until a window has them


class LiveWheel:
    """``late`` [s] is what frames are late by when they are read."""

    def __init__(self, mount: WheelMount, late: float = 0.0) -> None:
        self._mount, self._late = mount, late
        self.reset()

    def reset(self) -> None:
        """Let all go that hangs on the unit's time."""
        self._times = FixTimes(STAMPS_NS)
        self._speeds, self._aid = no_speeds(), None
        self._newest = self._now = -np.inf
        self._age = 0.0  # s, of the newest speed when it came

    _aid: WheelAid | None

    def mark(self, marks: Iterable[tuple[int, float]]) -> None:
        """Take moments of reading [ns] and the device times [s] of the samples that came then."""
        for host_ns, device_s in marks:
            self._times.stamp_imu(host_ns, device_s)

    def take(self, readings: Sequence[WheelReading], now: float) -> None:
        """Take what was stated; ``now`` [s] is the newest sample's time."""
        self._now = now
        speeds = list[tuple[float, float]]()
        for reading in readings:
            t = self._times.of(reading)
            if t is not None and t - self._late > self._newest and abs(now - t) < STRANGE_S:
                self._newest = t - self._late
                speeds.append((self._newest, reading.speed))
        self._age = now - self._newest if speeds else self._age
        more = WheelSpeeds(*np.array(speeds).reshape(-1, 2).T)
        if self._aid is not None:
            self._aid.add(more)
        elif len(speeds):
            self._speeds = self._speeds.followed_by(more).since(now - KEPT_S)

    def aid(self, noise: ImuNoise) -> WheelAid:
        """Return what a window that begins now is to be given."""
        self._aid = WheelAid(self._mount, self._speeds, noise)
        return self._aid

    def text(self, window: InnerWindow | None) -> str:
        """How the wheel does, as text."""
        if self._newest == -np.inf:
            return "no speed yet"
        if (silent := self._now - self._newest) > SILENT_S:
            return f"no speed for {silent:.0f} s"
        if window is None or self._aid is None:
            return "it waits for position and heading"
        if self._aid.late:
            return f"its speeds arrive {self._age:.1f} s late: too late for use"
        if self._aid.slips_now:
            return "it slips"
        return f"scale {1 + window.state.wheel:.4f} +- {window.wheel_std:.4f}"


MIN_LEVEL_PART = 0.1  # of forward's length across the vertical, below which it has no heading
MAX_POINTS = 2000  # points
INITIAL_SPACING_M = 0.2  # m between two points, at first; twice as much each time it is thinned
MAX_DRAWN_OUTLIERS = 200  # outliers that are drawn
Place = tuple[float, float]


class LocationReport:
    """``ahead`` (3,) is forward in IMU axes. The way gone is evenly thinned, as a map draws it."""

    def __init__(self, ahead: FloatArray) -> None:
        self._ahead = ahead
        self._points, self._track = list[Place](), tuple[Place, ...]()
        self._step, self._outliers = INITIAL_SPACING_M, 0
        self._far: tuple[Place, ...] = ()
        self.reset()

    def reset(self) -> None:
        """Go on with the same track."""
        self._std: FloatArray = np.zeros(3)  # of the last place

    def look_at(self, place: FloatArray, std: float, fix: FloatArray) -> None:
        """Count a fix (3,) [m] that stands off the antenna's place (3,) beyond its uncertainty."""
        if np.linalg.norm((fix - place) / np.hypot(std, self._std)) > OUTLIER_SIGMAS:
            self._outliers += 1
            self._far = (*self._far, (float(fix[0]), float(fix[1])))[-MAX_DRAWN_OUTLIERS:]

    def location(self, pose: GlobalPose, velocity: FloatArray, origin: LocalLevel, fixes: LiveFixes) -> Location:
        """Return what is known at a pose, with its ``velocity`` (3,) [m/s].

        The place is no better than the receiver says of itself: its errors last for minutes, they do not average.
        """
        self._draw(float(pose.p[0]), float(pose.p[1]))
        std = np.sqrt(np.diag(pose.covariance))
        self._std = std[:3]
        ahead = pose.C_nb @ self._ahead
        is_level = bool(np.hypot(*ahead[:2]) > MIN_LEVEL_PART)
        latitude, longitude, height = origin.geodetic(pose.p)
        return Location(
            is_located=True, t=pose.t, enu=_three(pose.p), enu_std=_three(np.hypot(std[:3], fixes.std)),
            velocity=_three(velocity),
            heading=float(np.degrees(np.arctan2(ahead[0], ahead[1])) % 360) if is_level else None,
            heading_std=float(np.degrees(std[3])),
            latitude=float(np.degrees(latitude)), longitude=float(np.degrees(longitude)), height=height,
            fixes=fixes.count, outliers=self._outliers, fix_age=pose.t - fixes.newest_taken,
            track=self._track, far=self._far,
        )  # fmt: skip

    def _draw(self, east: float, north: float) -> None:
        if self._points and np.hypot(east - self._points[-1][0], north - self._points[-1][1]) < self._step:
            return
        self._points.append((east, north))
        if len(self._points) > MAX_POINTS:
            del self._points[1::2]
            self._step *= 2
        self._track = tuple(self._points)


def _three(vector: FloatArray) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z
