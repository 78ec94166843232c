"""Tracks of a folder on the IMU's clock: by what was told of the camera's, or by what its turns say."""

from dataclasses import dataclass

import numpy as np

from procedures.fusion.aligner import between
from procedures.fusion.alignment import Waiting
from procedures.fusion.camera_time import CameraOffset, camera_offset
from procedures.fusion.records import ImuSeries
from procedures.fusion.tracks import Tracks
from station.fusion_folder import FusionLog

FIRST = 5.0  # s of tracks after which it is worth a try
STEP = 1.0  # s between attempts until it is found
AGAIN = 10.0  # s after which it is found anew
SPAN = 20.0  # s that are looked at
UNASKED = 0.1  # s, 1 sigma, where nothing was said
SURE = 5.0  # sigmas from which an offset is one
HARMLESS = 0.005  # s, that a window hardly feels: docs/locate-vision.md


@dataclass(frozen=True, slots=True, eq=False)
class ClockedTracks:
    """Tracks on the IMU's clock; ``told`` [s] and the last ``found`` of their offset, first known at ``since``."""

    tracks: Tracks
    told: float | None
    found: CameraOffset | None = None
    since: float = -np.inf


def on_imu_clock(log: FusionLog) -> ClockedTracks | Waiting:
    """Shift a folder's tracks by the offset that is told, or found where ``time_offset_std_s`` asks for it.

    A camera's own clock walks away from the IMU's, 3 ms in a minute at 50 ppm: what was found is found again all
    along. Frames later than ``since`` are shifted by what was known before them.
    """
    assert log.imu is not None and log.tracks is not None  # noqa: PT018
    told, std = _told(log)
    if std is None:
        return ClockedTracks(log.tracks.shifted(told or 0.0), told)
    why = Waiting(f"IMU and camera overlap for less than {FIRST:g} s")
    now, end = (pick(log.imu.t[at], log.tracks.t[at]) for pick, at in ((max, 0), (min, -1)))
    now += FIRST
    known = list[tuple[float, CameraOffset]]()
    while now < end:
        found = _attempt(log, log.imu, log.tracks, now, told or 0.0, std)
        if isinstance(found, CameraOffset):
            known.append((now, found))
        else:
            why = found
        now += AGAIN if known else STEP
    if not known:
        return why
    return ClockedTracks(followed(log.tracks, known), told, known[-1][1], known[0][0])


def followed(tracks: Tracks, known: list[tuple[float, CameraOffset]]) -> Tracks:
    """Shift each frame by what was known when it was taken, the first ones by the first; none runs back."""
    later = np.searchsorted([now for now, _ in known[1:]], tracks.t + known[0][1].offset, "right")
    t = tracks.t + np.array([found.offset for _, found in known])[later]
    rows = t >= np.maximum.accumulate(t)
    return Tracks(t[rows], tracks.feature[rows], tracks.uv[rows])


def suspicion(log: FusionLog) -> str:
    """Return what the first turns that tell say of a camera's clock of which nothing was told, or nothing."""
    assert log.imu is not None and log.tracks is not None  # noqa: PT018
    if _told(log) != (None, None):
        return ""
    for now in np.arange(log.tracks.t[0] + SPAN, log.tracks.t[-1] + SPAN, SPAN):
        found = _attempt(log, log.imu, log.tracks, float(now), 0.0, UNASKED)
        if isinstance(found, CameraOffset):
            if abs(found.offset) < max(SURE * found.std, HARMLESS):
                return ""
            said = f"{found.offset * 1e3:.1f} +- {found.std * 1e3:.1f} ms"
            return f"the camera's stamps seem to be off by {said}: say time_offset_s in [tracks]"
    return ""


def _told(log: FusionLog) -> tuple[float | None, float | None]:
    """Return ``time_offset_s`` and ``time_offset_std_s`` of ``[tracks]`` [s]."""
    table = log.table.tracks
    return (None, None) if table is None else (table.time_offset_s, table.time_offset_std_s)


def _attempt(
    log: FusionLog, imu: ImuSeries, tracks: Tracks, now: float, about: float, std: float
) -> CameraOffset | Waiting:
    """Try with the last data before ``now`` [s]."""
    assert log.camera is not None
    rows = slice(*np.searchsorted(tracks.t, (now - SPAN, now)).tolist())
    part = Tracks(tracks.t[rows], tracks.feature[rows], tracks.uv[rows])
    return camera_offset(between(imu, now - SPAN - abs(about) - 1.0, now), part, log.camera, about, std)
