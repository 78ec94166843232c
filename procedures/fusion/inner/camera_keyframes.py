"""When a window with a camera has its keyframes: at frames, ten a second, and as often where there are none."""

from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import ImuSeries
from procedures.fusion.vision.feature_tracks import FeatureTracks

SPACING = 0.1  # s between keyframes, at most
CLOSEST = 0.09  # s: frames that follow sooner are left out


@dataclass(frozen=True, slots=True, eq=False)
class CameraKeyframes:
    """``t`` (n,) [s], and the rows of the tracks that each one saw, an empty slice where there is no frame."""

    t: FloatArray
    rows: tuple[slice, ...]


def camera_keyframes(tracks: FeatureTracks, imu: ImuSeries, first: float) -> CameraKeyframes:
    """Return keyframes from ``first`` [s] to the end of the IMU."""
    seen, begin = tracks.frames()
    times, rows = [first], [slice(0, 0)]
    for i in np.flatnonzero((seen >= first) & (seen <= imu.t[-1])):
        t = float(seen[i])
        if t == first:
            rows[0] = slice(int(begin[i]), int(begin[i + 1]))
        elif t - times[-1] >= CLOSEST:
            _fill(times, rows, t)
            times.append(t)
            rows.append(slice(int(begin[i]), int(begin[i + 1])))
    _fill(times, rows, float(imu.t[-1]))
    return CameraKeyframes(np.array(times), tuple(rows))


def _fill(times: list[float], rows: list[slice], until: float) -> None:
    parts = int(np.ceil((until - times[-1]) / SPACING - 0.5))  # half a spacing more is no gap
    between = np.linspace(times[-1], until, parts + 1)[1:-1] if parts > 1 else np.zeros(0)
    times.extend(between.tolist())
    rows.extend([slice(0, 0)] * len(between))
