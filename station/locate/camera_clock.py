"""Tracks of a folder on the IMU's clock: by what was told of the camera's, or by what its turns say."""

from dataclasses import dataclass

import numpy as np

from procedures.fusion.alignment.alignment_attempts import between
from procedures.fusion.alignment.alignment_result import Waiting
from procedures.fusion.fusion_records import ImuSeries
from procedures.fusion.vision.feature_tracks import FeatureTracks
from procedures.fusion.visual_alignment.camera_time import CameraTimeOffset, camera_offset
from station.files.fusion_folder import FusionLog

FIRST_ATTEMPT_S = 5.0  # s of tracks after which it is worth a try
ATTEMPT_INTERVAL_S = 1.0  # s between attempts
MIN_OFFSET_STD_S = 0.001  # s, 1 sigma with which the window goes on
UNKNOWN_OFFSET_STD_S = 0.01  # s, 1 sigma of a clock of which nothing was said
WINDOW_S = 20.0  # s that are looked at
SUSPECTED_OFFSET_STD_S = 0.1  # s, 1 sigma about 0, within which such a clock is looked for
SIGNIFICANT_SIGMAS = 5.0  # sigmas from which an offset is one
HARMLESS_OFFSET_S = 0.005  # s, that a window hardly feels: docs/how-to/locate-vision.md


@dataclass(frozen=True, slots=True, eq=False)
class ClockedTracks:
    """Tracks on the IMU's clock: ``offset`` [s] was added, known ``since``; 1 sigma ``std`` [s], 0 if given."""

    tracks: FeatureTracks
    offset: float
    std: float
    since: float = -np.inf


def on_imu_clock(log: FusionLog) -> ClockedTracks | Waiting:
    """Shift a folder's tracks by the offset that is told, or found where ``time_offset_std_s`` asks for it.

    What is found uses nothing later than ``since``. The window refines what is not given.
    """
    assert log.imu is not None and log.tracks is not None  # noqa: PT018
    told, std = _told(log)
    if std is None:
        return ClockedTracks(
            log.tracks.shifted(told or 0.0), told or 0.0, UNKNOWN_OFFSET_STD_S if told is None else 0.0
        )
    why = Waiting(f"IMU and camera overlap for less than {FIRST_ATTEMPT_S:g} s")
    start, end = (pick(log.imu.t[at], log.tracks.t[at]) for pick, at in ((max, 0), (min, -1)))
    for now in np.arange(start + FIRST_ATTEMPT_S, end, ATTEMPT_INTERVAL_S):
        found = _attempt(log, log.imu, log.tracks, float(now), told or 0.0, std)
        if isinstance(found, CameraTimeOffset):
            found_std = max(found.std, MIN_OFFSET_STD_S)
            return ClockedTracks(log.tracks.shifted(found.offset), found.offset, found_std, float(now))
        why = found
    return why


def suspected_offset(log: FusionLog) -> str:
    """Return what the first turns that tell say of a camera's clock of which nothing was told, or nothing."""
    assert log.imu is not None and log.tracks is not None  # noqa: PT018
    if _told(log) != (None, None):
        return ""
    for now in np.arange(log.tracks.t[0] + WINDOW_S, log.tracks.t[-1] + WINDOW_S, WINDOW_S):
        found = _attempt(log, log.imu, log.tracks, float(now), 0.0, SUSPECTED_OFFSET_STD_S)
        if isinstance(found, CameraTimeOffset):
            if abs(found.offset) < max(SIGNIFICANT_SIGMAS * found.std, HARMLESS_OFFSET_S):
                return ""
            said = f"{found.offset * 1e3:.1f} +- {found.std * 1e3:.1f} ms"
            return f"the camera's time stamps seem to be wrong by {said}: state time_offset_s in [tracks]"
    return ""


def _told(log: FusionLog) -> tuple[float | None, float | None]:
    """Return ``time_offset_s`` and ``time_offset_std_s`` of ``[tracks]`` [s]."""
    table = log.table.tracks
    return (None, None) if table is None else (table.time_offset_s, table.time_offset_std_s)


def _attempt(
    log: FusionLog, imu: ImuSeries, tracks: FeatureTracks, now: float, about: float, std: float
) -> CameraTimeOffset | Waiting:
    """Try with the last data before ``now`` [s]."""
    assert log.camera is not None
    rows = slice(*np.searchsorted(tracks.t, (now - WINDOW_S, now)).tolist())
    part = FeatureTracks(tracks.t[rows], tracks.feature[rows], tracks.uv[rows])
    return camera_offset(between(imu, now - WINDOW_S - abs(about) - 1.0, now), part, log.camera, about, std)
