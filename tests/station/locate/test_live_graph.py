"""A graph that is renewed stays as good as one that keeps everything, and keeps no more than it must."""

import numpy as np
import pytest

from procedures.fusion.odometry import OdometryDrift
from procedures.fusion.pose_graph import PoseGraph
from station.locate.live_alignment import LiveGraph
from tests.procedures.fusion.motions import Eight, only

DRIFT = OdometryDrift(0.02, 0.03, 0.01)


@pytest.mark.proof
def test_a_renewed_graph_is_as_good_and_no_larger_than_it_must_be() -> None:
    flight, rng = Eight(40.0), np.random.default_rng(2)
    odometry, fixes = flight.odometry(rng, DRIFT), flight.fixes(rng)
    whole = PoseGraph()
    poses = {pose.t: pose for pose in whole.run(odometry, fixes)}
    graph, at = LiveGraph(whole.settings, renewed=200, run_in=220), 1
    graph.add(fixes.part(slice(1)))
    off, renewed_off, sizes = list[float](), list[float](), set[int]()
    for pose in odometry.poses():
        new = np.flatnonzero((fixes.t <= pose.t + 0.05) & (np.arange(len(fixes.t)) >= at))
        if len(new):
            graph.add(only(fixes, new))
            at = int(new[-1]) + 1
        if (found := graph.take(pose)) is not None and pose.t in poses:
            true = flight.p(np.array(pose.t))
            off.append(float(np.linalg.norm(poses[pose.t].p - true)))
            renewed_off.append(float(np.linalg.norm(found.p - true)))
        sizes.add(len(graph._graph.association.t))  # noqa: SLF001
    assert len(off) > 500
    assert np.mean(renewed_off) < 1.1 * np.mean(off)
    assert renewed_off != off
    assert max(sizes) <= 420
