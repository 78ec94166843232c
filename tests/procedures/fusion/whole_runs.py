"""A window or a graph run to its end, known where this code was asked the same before.

What was handed to them stays as it was: look at ``window.wheel`` afterwards, not at the wheel that it was given.
"""

from procedures.fusion.fusion_records import GnssFixes
from procedures.fusion.inner.inner_window import InnerWindow
from procedures.fusion.odometry import OdometryPose, OdometrySource
from procedures.fusion.outer.pose_graph import GlobalPose, PoseGraph


def whole_track(window: InnerWindow) -> list[OdometryPose]:
    """Return all poses of a window, which stands at their end then."""
    poses, after = _track(window)
    vars(window).update(vars(after))
    return poses


def whole_run(graph: PoseGraph, source: OdometrySource, fixes: GnssFixes) -> list[GlobalPose]:
    """Return all poses of a graph; graph and source stand at their end then."""
    poses, *after = _run(graph, source, fixes)
    for each, ended in zip((graph, source), after, strict=True):
        if hasattr(each, "__dict__"):
            vars(each).update(vars(ended))
    return poses


def _track(window: InnerWindow) -> tuple[list[OdometryPose], InnerWindow]:
    return list(window.poses()), window


def _run(
    graph: PoseGraph, source: OdometrySource, fixes: GnssFixes
) -> tuple[list[GlobalPose], PoseGraph, OdometrySource]:
    return list(graph.run(source, fixes)), graph, source
