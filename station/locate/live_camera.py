"""The camera of a live run: frames on the IMU's clock, how late they are, and which keyframes they ask for.

Images are stamped by the camera's own clock where it reports one, else by when they were read. What its stamps are
late by all the same (exposure, read-out, the way here) is stated, or found out while the unit turns.
"""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice

import numpy as np

from drivers.camera import CameraImage
from procedures.arrays import FloatArray
from procedures.fusion.feature_tracks import FeatureTracks, PinholeCamera
from procedures.fusion.fusion_records import ImuSeries
from procedures.fusion.inner.window_state import (
    FRAME_SPACING_S,
    MIN_FRAME_SPACING_S,
    Frame,
    between,
    filled,
    no_frame,
)
from procedures.fusion.vision.camera_time import CHECK_MOUNTING, CameraTimeOffset, camera_offset
from procedures.gnss_records import TimeMark
from station.stream.camera import Follow
from station.stream.gnss_fix_times import FixTimes
from station.text import plural

STAMPS_NS = 60 * 10**9  # of the lines between the clocks
KEPT_S = 60.0  # of frames: by them the delay is found
ATTEMPT_SPACING_GROWTH = 1.2  # attempts are as much farther apart each time, up to
MAX_ATTEMPT_SPACING_S = 5.0
AGE_FRAMES = 20  # frames, whose lateness is looked at
REACH_S = 4.0  # s that a window goes back for frames, at most
MAX_WAIT_S = 0.05  # beyond what fixes are waited for, that is waited for a frame
MAX_BETWEEN_S2 = 0.005  # product of the times to two frames, up to which image points between them lie on a line
SAME_S = 0.001  # s, within which a frame is a keyframe's
EARLY_S = 0.06  # by which a frame is to be known before a keyframe comes near it
SILENT_S = 2.0
MIN_IMAGE_SPACING_S = 0.03  # between images that are followed
TURN_ADVICE = "its delay is not known: rotate it unevenly"
MISFIT_ADVICE = "its rotations differ from the gyro's: check its file"
UNKNOWN_OFFSET = CameraTimeOffset(0.0, 0.1)
GENTLE_S = 0.015  # 1 sigma of the delay that does where all turns are gentle: the window continues fitting it


class LiveCamera:
    """``stated`` is the offset to be added to the camera's stamps; with a sigma, or None, it is found.

    ``why`` says what is missing.
    """

    def __init__(self, camera: PinholeCamera, follow: Follow, stated: CameraTimeOffset | None = None) -> None:
        self.camera, self._follow, self._stated_offset = camera, follow, stated
        self.reset()

    def reset(self) -> None:
        """Let all go that hangs on the unit's time."""
        self.offset = (
            self._stated_offset if self._stated_offset is not None and not self._stated_offset.std else None
        )
        self.why, self._hint = "no image yet", TURN_ADVICE
        self._times = FixTimes(STAMPS_NS, in_order=True)
        self._frames: deque[Frame] = deque()  # by the camera's stamps, without the offset
        self._ages: deque[float] = deque(maxlen=AGE_FRAMES)
        self._came_at = -np.inf
        self._now, self._try_at, self._pause = -np.inf, -np.inf, 1.0
        self._spoilt_at = -np.inf
        self._followed_at = -np.inf
        self._judged = -np.inf
        self.dropped = 0  # images that came when no keyframe of the window was as old, or that nobody had time for
        self.fitted = 0.0  # s, what a window has to add to the offset

    def mark(self, marks: Iterable[tuple[int, float]]) -> None:
        """Take moments of reading [ns] and the device times [s] of the samples that came then."""
        for host_ns, device_s in marks:
            self._times.stamp_imu(host_ns, device_s)

    def take(self, images: Sequence[CameraImage], now: float) -> None:
        """Follow features through new images; ``now`` [s] is the newest sample's time."""
        self._now = now
        for image in images:
            if image.device_ns is not None:
                self._times.stamp_sender(TimeMark(image.host_ns, image.device_ns, None))
            t = self._times.of(image)
            if t is not None and self._followed_at < t < self._followed_at + MIN_IMAGE_SPACING_S:
                continue  # more often than it is worth: a machine that cannot keep up falls behind
            seen, self._followed_at = self._follow(image), t if t is not None else -np.inf
            self._spoilt_at = now if seen is None else self._spoilt_at
            if t is not None and seen is not None and abs(now - t) < KEPT_S and t > self._newest:
                self._frames.append(Frame(t, *seen))
                self._ages.append(now - t)
                self._came_at = now
        while self._frames and self._frames[0].t < now - KEPT_S:
            self._frames.popleft()

    @property
    def is_due(self) -> bool:
        """Whether it is time to find out what the stamps are late by."""
        return self.offset is None and self._now - self._came_at < SILENT_S and self._now >= self._try_at

    def learn(self, imu: ImuSeries) -> None:
        """Find out what the stamps are late by."""
        self._pause = min(self._pause * ATTEMPT_SPACING_GROWTH, MAX_ATTEMPT_SPACING_S)
        self._try_at = self._now + self._pause
        known = self._stated_offset or UNKNOWN_OFFSET
        found = camera_offset(imu, self._tracks(-np.inf, 0.0), self.camera, known.offset, known.std, GENTLE_S)
        if isinstance(found, CameraTimeOffset):
            self.offset = found
        else:
            self.why = f"its delay is not known: {found.why}"
            self._hint = MISFIT_ADVICE if CHECK_MOUNTING in found.why else TURN_ADVICE

    @property
    def offset_std(self) -> float:
        """1 sigma [s] of what a window has to add to the offset; 0 where that was stated."""
        return GENTLE_S if self._stated_offset is None or self._stated_offset.std else 0.0

    @property
    def lateness(self) -> float:
        """How far behind the newest sample [s] keyframes would have to stand for each to have its frame."""
        late = max(self._ages, default=0.0) - (self.offset.offset if self.offset is not None else 0.0)
        return max(late + EARLY_S, 0.0)

    @property
    def _newest(self) -> float:
        return self._frames[-1].t if self._frames else -np.inf

    def tracks(self, first: float = -np.inf) -> FeatureTracks:
        """Return what was seen from ``first`` [s] on by the IMU's clock; nothing where that is not known yet."""
        if self.offset is None:
            return self._tracks(np.inf, 0.0)
        return self._tracks(first - self.offset.offset, self.offset.offset)

    def _tracks(self, first: float, offset: float) -> FeatureTracks:
        frames = [frame for frame in self._frames if frame.t >= first and len(frame.feature)]
        return FeatureTracks(
            np.concatenate([np.zeros(0), *(np.full(len(frame.feature), frame.t + offset) for frame in frames)]),
            np.concatenate([np.zeros(0, np.int64), *(frame.feature for frame in frames)]),
            np.concatenate([np.zeros((0, 2)), *(frame.uv for frame in frames)]),
        )

    def lags(self, others: float) -> bool:
        """Return whether frames are not waited for: ``others`` [s] is how late what is waited for is."""
        return self.lateness > others + MAX_WAIT_S

    @property
    def awaited(self) -> int:
        """How many keyframes stand before the frame that comes next, if that is still of use."""
        if self.offset is None or self._now - self._came_at > SILENT_S:
            return 0
        if min(self._ages) - self.offset.offset > REACH_S:
            return 0
        return int(np.ceil(min(self.lateness, REACH_S) / FRAME_SPACING_S))

    def due(self, last: float, until: float, *, lags: bool = False) -> Iterator[Frame]:
        """Yield the keyframes after ``last`` [s] that are due up to ``until``: at frames, and as often without.

        Where it ``lags`` they stand without a frame where one is likely to be: see `late`.
        """
        while (frame := self._next(last, until, lags=lags)) is not None:
            yield from filled(last, frame)
            last = frame.t

    def late(self, times: FloatArray, seen_until: float) -> Iterator[Frame]:
        """Yield what was seen at keyframes ``times`` (k,) [s] after ``seen_until``, now that it has come.

        Between two images an image point lies on a line; what is older than all keyframes is `dropped`.
        """
        if self.offset is None or not self._frames:
            return
        t = np.array([frame.t for frame in self._frames]) + self.offset.offset
        self.dropped += int(np.sum((t > max(self._judged, seen_until)) & (t < times[0] - SAME_S)))
        self._judged = float(t[-1])
        for time in times[(times > seen_until) & (times <= t[-1] + SAME_S)].tolist():
            after = int(np.searchsorted(t, time))
            near = min(range(max(after - 1, 0), min(after + 1, len(t))), key=lambda i: abs(t[i] - time))
            if abs(t[near] - time) <= SAME_S:
                yield Frame(time, self._frames[near].feature, self._frames[near].uv)
            elif 0 < after < len(t) and (time - t[after - 1]) * (t[after] - time) < MAX_BETWEEN_S2:
                part = float((time - t[after - 1]) / (t[after] - t[after - 1]))
                yield _between(self._frames[after - 1], self._frames[after], part, time)

    def _likely(self, last: float) -> float:
        """Return when the keyframe after ``last`` [s] is to stand: at the next frame, or half way there."""
        if self.offset is None or len(self._frames) < AGE_FRAMES:
            return last + FRAME_SPACING_S
        t = np.array([frame.t for frame in islice(reversed(self._frames), AGE_FRAMES)]) + self.offset.offset
        period = -float(np.median(np.diff(t)))
        at = t[0] + np.ceil((last + MIN_FRAME_SPACING_S - t[0]) / period) * period
        return float([*between(last, at, FRAME_SPACING_S), at][0])

    def _next(self, last: float, until: float, *, lags: bool) -> Frame | None:
        found: Frame | None = None
        if self.offset is not None:
            for frame in reversed(self._frames):
                if (t := frame.t + self.offset.offset) < last + MIN_FRAME_SPACING_S:
                    break
                found = Frame(t, frame.feature, frame.uv)
        if found is not None and found.t <= until:
            return found
        if lags:
            return no_frame(at) if (at := self._likely(last)) <= until else None
        return no_frame(last + FRAME_SPACING_S) if until - last > 1.5 * FRAME_SPACING_S else None

    @property
    def text(self) -> str:
        """How the camera does, as text."""
        silent = self._now - self._came_at
        if silent > SILENT_S >= self._now - self._spoilt_at:
            return "images are not JPEG, or their size differs from the first"
        if SILENT_S < silent < np.inf:
            return f"no image for {silent:.0f} s"
        if not self._frames:
            return self.why
        if self.offset is None:
            return self._hint
        dropped = f", {plural(self.dropped, 'image')} dropped" if self.dropped else ""
        if (age := min(self._ages) - self.offset.offset) > REACH_S:
            return f"images are {age:.1f} s late, usable up to {REACH_S:g} s{dropped}"
        features, late = plural(len(self._frames[-1].feature), "feature"), -self.offset.offset - self.fitted
        return f"{features}, stamps {late * 1e3:.0f} ms late{dropped}"


def _between(before: Frame, after: Frame, part: float, t: float) -> Frame:
    """Return what was seen ``part`` of the way between two frames: what both have."""
    feature, i, j = np.intersect1d(before.feature, after.feature, assume_unique=True, return_indices=True)
    return Frame(t, feature, before.uv[i] + part * (after.uv[j] - before.uv[i]))
