"""Locate by the inner window alone, GNSS position in it."""

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.fusion.alignment.alignment_result import AlignmentState
from procedures.fusion.fusion_records import Trajectory
from procedures.fusion.inner.inertial_window import InertialWindow
from procedures.fusion.outer.pose_graph import OUTLIER_SIGMAS, GlobalPose
from station.locate.outer_layer import timed, trajectory_of
from station.locate.result import Located


def one_layer(window: InertialWindow, aligned: AlignmentState) -> Located:
    """Run a window of one layer; poses before the alignment was found are not online."""
    poses, seconds = timed(GlobalPose(pose.t, pose.p_o, pose.C_ob, window.covariance_n) for pose in window.poses())
    online = [k for k, pose in enumerate(poses) if pose.t >= aligned.t]
    found = window.smoothed()
    smoothed = trajectory_of([GlobalPose(t, p, C, np.zeros((4, 4))) for t, p, C in found])
    return Located(
        trajectory_of([poses[k] for k in online]), smoothed, poses[online[0]].t, "",
        _outliers(window, smoothed), seconds[online], layers=1, lever_arm=window.constants[:3],
        covariance=np.array([poses[k].covariance for k in online]),
    )  # fmt: skip


def _outliers(window: InertialWindow, smoothed: Trajectory) -> int:
    """Return how many fixes stand off the smoothed trajectory; nothing weighted them down."""
    at = np.flatnonzero(window.frames.at >= 0)
    fix = window.frames.at[at]
    antenna = smoothed.p[at] + Rotation.from_quat(smoothed.q[at]).apply(window.constants[:3])
    off = np.linalg.norm(antenna - window.fixes.p_n[fix], axis=1) / window.fixes.position_std[fix]
    return int(np.count_nonzero(off > OUTLIER_SIGMAS))
