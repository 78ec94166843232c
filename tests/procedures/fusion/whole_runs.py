"""A window or a graph run to its end."""

from procedures.fusion.fusion_records import GnssFixes
from procedures.fusion.inner.inner_window import InnerWindow
from procedures.fusion.odometry import OdometryPose, OdometrySource
from procedures.fusion.pose_graph import GlobalPose, PoseGraph


def whole_track(window: InnerWindow) -> list[OdometryPose]:
    return list(window.poses())


def whole_run(graph: PoseGraph, source: OdometrySource, fixes: GnssFixes) -> list[GlobalPose]:
    return list(graph.run(source, fixes))
