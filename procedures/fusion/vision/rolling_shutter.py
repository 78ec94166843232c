"""A rolling shutter's rows brought to the moment of their frame, as far as the gyro knows it.

What is seen in a row that was taken late by d was seen by a camera that had turned by ``w d``; where it would have
stood in the frame's own moment is that turn back. How far the camera went meanwhile depends on how far off things
are: that is for a window, which knows it (`procedures.fusion.inner.reprojection`).
"""

import numpy as np

from procedures.arrays import interpolated
from procedures.frames import rotation
from procedures.fusion.fusion_records import ImuSeries
from procedures.fusion.vision.feature_tracks import FeatureTracks, PinholeCamera

SMOOTHED = 5  # samples whose mean is a rate: one alone is vibration


def derotated(tracks: FeatureTracks, imu: ImuSeries, camera: PinholeCamera) -> FeatureTracks:
    """Return the tracks as a camera had them that takes all rows at once; the same where this one does."""
    if not camera.row_time or not len(tracks.t):
        return tracks
    kernel = np.ones(SMOOTHED)
    count = np.convolve(np.ones(len(imu.t)), kernel, "same")  # fewer at the ends
    omega = np.stack([np.convolve(each, kernel, "same") / count for each in imu.omega_b.T], axis=1)
    rays = camera.rays(tracks.uv)
    rate_c = interpolated(tracks.t, imu.t, omega) @ camera.C_bc
    back = rotation(rate_c * (camera.ray_time * rays[:, 1:]))
    there = np.einsum("nij,nj->ni", back, np.column_stack((rays, np.ones(len(rays)))))
    return FeatureTracks(tracks.t, tracks.feature, camera.pixels(there[:, :2] / there[:, 2:]))
