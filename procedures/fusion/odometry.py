"""Where relative motion comes from: one interface, whatever measured it."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import Trajectory

MAX_TURN_RATE = np.radians(1000.0)  # rad/s: a step beyond it is a restart, not a motion (fusion/1)
MAX_SPEED = 100.0  # m/s


@dataclass(frozen=True, slots=True, eq=False)
class AntennaEstimate:
    """What a source knows of the antenna, where it estimates that itself.

    ``lever`` (3,) [m] in b and ``time_offset`` [s], to be added to the fixes' stamps, with ``covariance`` (4, 4).
    """

    lever: FloatArray
    covariance: FloatArray
    time_offset: float


@dataclass(frozen=True, slots=True, eq=False)
class OdometryPose:
    """One pose of a source, in its own level frame o.

    ``t`` [s], ``p_o`` (3,) [m], ``C_ob`` (3, 3). ``drift`` (4, 4) is the covariance of the step from the pose
    before: x, y, z [m] and yaw [rad]. ``yaw_std`` [rad] is 1 sigma of the frame's heading against North where the
    source knows it; None: free. ``own_yaw_std`` [rad] is 1 sigma of the IMU's heading in that frame, where the
    source knows it. ``uses_velocity``: GNSS velocity is already in it and must not be used again.
    ``revised`` are the poses right before this one that have changed since they were reported; those
    after ``open_since`` [s] may still be. None: no more of them.
    """

    t: float
    p_o: FloatArray
    C_ob: FloatArray
    drift: FloatArray
    yaw_std: float | None = None
    uses_velocity: bool = False
    own_yaw_std: float = 0.0
    antenna: AntennaEstimate | None = None
    revised: tuple["OdometryPose", ...] = ()
    open_since: float | None = None


class OdometrySource(Protocol):
    """What a graph draws poses from, in the order of time, none of which knows what comes later."""

    def poses(self) -> Iterator[OdometryPose]:
        """Yield the poses."""
        ...


@dataclass(frozen=True, slots=True)
class OdometryDrift:
    """How an odometry errs: a random walk in time and in distance.

    ``per_root_s`` [m/sqrt(s)], ``per_root_m`` [m/sqrt(m)], ``yaw_per_root_s`` [rad/sqrt(s)]. The defaults fit
    visual-inertial odometry (SVO on EuRoC: docs/how-to/locate.md has the search).
    """

    per_root_s: float = 0.015
    per_root_m: float = 0.03
    yaw_per_root_s: float = 0.008

    def covariance(self, dt: float, distance: float) -> FloatArray:
        """Return the covariance (4, 4) of a step of ``dt`` [s] over ``distance`` [m]."""
        moved = self.per_root_s**2 * dt + self.per_root_m**2 * distance
        return np.diag([moved, moved, moved, self.yaw_per_root_s**2 * dt])


@dataclass(frozen=True, slots=True, eq=False)
class RecordedOdometry:
    """Replays a trajectory that somebody else's odometry left."""

    trajectory: Trajectory
    drift: OdometryDrift = OdometryDrift()

    def poses(self) -> Iterator[OdometryPose]:
        """Yield the poses; the heading of their frame is free."""
        t, p = self.trajectory.t, self.trajectory.p
        C = Rotation.from_quat(self.trajectory.q).as_matrix()
        distance = np.linalg.norm(np.diff(p, axis=0, prepend=p[:1]), axis=1)
        for i in range(len(t)):
            yield OdometryPose(t[i], p[i], C[i], self.drift.covariance(t[i] - t[max(i - 1, 0)], distance[i]))


def without_restarts(trajectory: Trajectory) -> tuple[Trajectory, int]:
    """Return what follows the last step that no motion explains, and how many poses stood before it."""
    dt = np.diff(trajectory.t)
    q = Rotation.from_quat(trajectory.q)
    turn = (q[:-1].inv() * q[1:]).magnitude() / dt
    speed = np.linalg.norm(np.diff(trajectory.p, axis=0), axis=1) / dt
    torn = np.flatnonzero((turn > MAX_TURN_RATE) | (speed > MAX_SPEED))
    first = int(torn[-1]) + 1 if len(torn) else 0
    return Trajectory(trajectory.t[first:], trajectory.p[first:], trajectory.q[first:]), first
