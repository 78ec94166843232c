"""Where a unit is and which way it points while it is carried: samples and fixes in, a location out.

All follows from the samples, the fixes and the moments at which both were read, so that a replay gives the same.
A keyframe stands at each fix and at least every 50 ms, as far behind the newest sample as fixes are late.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.earth import earth_rate_n, normal_gravity
from procedures.fusion.inertial_window import WindowSettings
from procedures.fusion.keyframes import CLOSEST, SPACING
from procedures.fusion.live_window import LiveWindow
from procedures.fusion.moving_aligner import MovingAligner
from procedures.fusion.outer_graph import REJECTED, GlobalPose, OuterSettings
from procedures.fusion.records import GnssFixes, ImuNoise, ImuSeries
from procedures.geodesy import LocalLevel
from procedures.gnss import GnssFix, TimeMark
from procedures.level_fixes import antenna, is_usable, level_fixes, origin_at
from station.gnss.fix_times import FixTimes
from station.locate.imu_noise import NoiseOf
from station.locate.live_beginning import KEPT, Beginning, joined
from station.locate.live_graph import LiveGraph
from station.locate.live_track import Track
from station.locate.through_graph import FREE_ARM
from station.mcap_files.fix_reader import Record
from station.monitor.view import Location

MARKS_NS = 60 * 10**9  # of the lines between the clocks
BEHIND = (0.1, 1.0)  # s: how far behind the newest sample keyframes may stand
EARLY_S = 0.06  # by which a fix is to be known before a keyframe comes near it
AGES = 20  # fixes, whose lateness is looked at
TRY_EVERY_S = 1.0
MOST_FIXES, HALF = 2000, 1000  # that are kept once it is located


@dataclass(frozen=True, slots=True, eq=False)
class Taken:
    """A tenth of a second: samples in SI, IMU axes; ``marks`` of reading [ns] and their device times [s]."""

    imu: ImuSeries
    marks: Sequence[tuple[int, float]]
    records: Sequence[Record]


class LiveLocator:
    """Call `take` for each tick; ``location`` is what is known then.

    ``ahead`` (3,) is forward in IMU axes; ``lever_arm`` (3,) [m] from IMU to antenna, None: estimated.
    """

    def __init__(self, noise_of: NoiseOf, ahead: FloatArray, lever_arm: FloatArray | None = None) -> None:
        self._noise_of, self._ahead, self._arm = noise_of, ahead, lever_arm
        self._origin: LocalLevel | None = None
        self._source = ""
        self._track = Track()
        self.begin_anew()

    def begin_anew(self) -> None:
        """Begin again: the unit's time has no relation to what came before."""
        self._times = FixTimes(MARKS_NS)
        self._imu: deque[ImuSeries] = deque()
        self._fixes: GnssFixes | None = None
        self._taken = 0  # of the fixes kept, by the window
        self._count = 0
        self._ages: deque[float] = deque(maxlen=AGES)
        self._beginning: Beginning | None = None
        self._window: LiveWindow | None = None
        self._graph: LiveGraph | None = None
        self._try_at = -np.inf
        self.location = Location(why="no fix yet")

    def take(self, taken: Taken) -> None:
        """Go on by a tick."""
        for host_ns, device_s in taken.marks:
            self._times.mark_imu(host_ns, device_s)
        self._imu.append(taken.imu)
        now = float(taken.imu.t[-1])
        self._take_fixes(taken.records, now)
        while now - self._imu[0].t[-1] > (KEPT if self._window is None else 2 * BEHIND[1]):
            self._imu.popleft()
        if self._fixes is None:
            return
        if self._window is None:
            self._try_to_begin(self._fixes)
        else:
            self._go_on(now)

    def _take_fixes(self, records: Sequence[Record], now: float) -> None:
        """Place new fixes on the IMU's clock and in the level frame about the first."""
        for record in records:
            if isinstance(record, TimeMark):
                self._times.mark_sender(record)
            elif isinstance(record, GnssFix) and is_usable(record):
                self._source = self._source or antenna([record])
                t = self._times.of(record) if record.source == self._source else None
                if t is not None and (self._fixes is None or t > self._fixes.t[-1]):
                    self._place(record, t, now)

    def _place(self, fix: GnssFix, t: float, now: float) -> None:
        self._origin = self._origin or origin_at(fix)
        self._ages.append(now - t)
        new = level_fixes(self._origin, np.array([t]), [fix])
        self._fixes = new if self._fixes is None else self._fixes.followed_by(new)
        self._count += 1
        if self._graph is not None:
            self._graph.add(new)
            if len(self._fixes.t) > MOST_FIXES:
                self._fixes, self._taken = self._fixes.part(slice(HALF, None)), max(self._taken - HALF, 0)

    def _try_to_begin(self, fixes: GnssFixes) -> None:
        now = float(self._imu[-1].t[-1])
        if now < self._try_at:
            return
        self._try_at, imu = now + TRY_EVERY_S, joined(list(self._imu))
        if not np.isfinite(fixes.v_n[:, 0]).any():
            self.location = Location(
                why="the receiver tells no speed and course, which it needs", fixes=self._count
            )
            return
        if self._beginning is None:
            noise = self._noise_of(imu)
            if noise is None:
                self.location = Location(why="keep it still for 10 s: its noise is learnt", fixes=self._count)
                return
            self._beginning = Beginning(self._aligner(noise))
        found = self._beginning.attempt(imu, fixes)
        self.location = Location(why=self._beginning.why, fixes=self._count)
        if found is None:
            return
        a = self._aligner(self._beginning.noise)
        lever = a.lever if found.aligned.lever is None else found.aligned.lever
        settings = WindowSettings(a.noise, a.gravity, a.earth_n, lever, lever_std=a.lever_std)
        self._window = LiveWindow(settings, found.imu, found.fixes, found.aligned)
        self._graph = LiveGraph(OuterSettings(lever_arm=lever))
        self._graph.add(fixes)
        self._taken = len(fixes.t)
        for pose in self._window.poses():
            if (known := self._graph.take(pose)) is not None and pose.t >= found.aligned.t:
                self._show(known, -1)

    def _aligner(self, noise: ImuNoise) -> MovingAligner:
        assert self._origin is not None
        latitude = self._origin.latitude
        arm = np.zeros(3) if self._arm is None else self._arm
        gravity = normal_gravity(latitude, self._origin.height)
        return MovingAligner(
            noise, gravity, earth_rate_n(latitude), arm, None if self._arm is not None else FREE_ARM
        )

    def _go_on(self, now: float) -> None:
        """Add the keyframes that are due."""
        assert self._window is not None
        assert self._fixes is not None
        assert self._graph is not None
        late = float(np.clip(max(self._ages, default=0.0) + EARLY_S, *BEHIND))
        imu = joined(list(self._imu))
        while (due := self._due(now - late)) is not None:
            t, fix = due
            pose = self._window.go_on(t, imu, self._fixes, fix)
            if (known := self._graph.take(pose)) is not None:
                self._show(known, fix)

    def _due(self, until: float) -> tuple[float, int] | None:
        """Return the next keyframe's time and fix (-1: none) up to ``until`` [s], None where none is due."""
        assert self._window is not None
        assert self._fixes is not None
        last, t = float(self._window.frames.t[-1]), self._fixes.t
        while self._taken < len(t) and t[self._taken] < last + CLOSEST:
            self._taken += 1  # on the heels of a keyframe, or too late
        if self._taken < len(t) and (gap := float(t[self._taken]) - last) < 2 * SPACING + CLOSEST:
            parts = max(1, int(np.ceil(gap / SPACING - 0.5)))
            at, fix = (float(t[self._taken]), self._taken) if parts == 1 else (last + gap / parts, -1)
        else:
            at, fix = last + SPACING, -1
        if at > until:
            return None
        self._taken += fix >= 0
        return at, fix

    def _show(self, pose: GlobalPose, fix: int) -> None:
        assert self._window is not None
        assert self._fixes is not None
        assert self._graph is not None
        assert self._origin is not None
        if fix >= 0:
            self._look_at(fix, pose)
        self._track.add(pose.p)
        std = np.sqrt(np.diag(pose.covariance))
        ahead = pose.C_nb @ self._ahead
        v = self._window.state.v if self._window.state is not None else np.zeros(3)
        level = bool(np.hypot(*ahead[:2]) > 0.1)
        latitude, longitude, height = self._origin.geodetic(pose.p)
        self.location = Location(
            is_located=True, t=pose.t, enu=_three(pose.p), enu_std=_three(std[:3]), velocity=_three(v),
            heading=float(np.degrees(np.arctan2(ahead[0], ahead[1])) % 360) if level else None,
            heading_std=float(np.degrees(std[3])),
            latitude=float(np.degrees(latitude)), longitude=float(np.degrees(longitude)), height=height,
            fixes=self._count, outliers=self._track.outliers, fix_age=pose.t - float(self._last_fix()),
            track=self._track.points, far=self._track.far,
        )  # fmt: skip

    def _last_fix(self) -> float:
        assert self._fixes is not None
        return float(self._fixes.t[max(self._taken - 1, 0)])

    def _look_at(self, fix: int, pose: GlobalPose) -> None:
        """Count a fix that stands off by more than chance."""
        assert self._fixes is not None
        assert self._graph is not None
        off = self._fixes.p_n[fix] - pose.p - pose.C_nb @ self._graph.lever_arm
        if np.linalg.norm(off) > REJECTED * self._fixes.position_std[fix]:
            self._track.add_outlier(self._fixes.p_n[fix])


def _three(vector: FloatArray) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z
