"""Han's outer layer: odometry's steps, GNSS positions and courses in one graph of four degrees of freedom.

A window of nodes is solved again at every fix; what leaves it is eliminated into a prior. Between fixes the last
node is carried on by the odometry, its sigma growing. The whole chain is solved again for the smoothed trajectory.
Han 2022 (IV.B) keeps a large window at a low rate; a solve at every fix is worth a third of the error.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.fusion.fix_association import MAX_TRACK_MISFIT, FixAssociation, TrackYaw
from procedures.fusion.fusion_records import GnssFixes, Trajectory
from procedures.fusion.odometry import OdometryPose, OdometrySource
from procedures.fusion.pose_graph_terms import LEVER, NodeLayout, NodePrior, eliminate, linearise, rz, solve_chain

OUTLIER_SIGMAS = 5.0  # whitened length of three axes beyond which a fix counts as an outlier: 2e-5 by chance
MAX_START_YAW_STD = np.radians(3.0)  # 1 sigma of the yaw by track with which the graph begins
LOOSE_POSITION_STD = 1e3  # m, the position before the first fix
MAX_ITERATIONS = 8  # iterations of the smoothed solve


@dataclass(frozen=True, slots=True, eq=False)
class PoseGraphSettings:
    """What is given: lever arm (3,) [m] in b, time offset [s] to add to GNSS stamps; a sigma has it estimated."""

    window: float = 10.0
    lever_arm: FloatArray | None = None
    lever_arm_std: float | None = None
    time_offset: float = 0.0
    time_offset_std: float | None = None

    @property
    def layout(self) -> NodeLayout:
        """Which constants are estimated."""
        return NodeLayout(self.lever_arm_std is not None, self.time_offset_std is not None)

    @property
    def arm(self) -> FloatArray:
        """The lever arm (3,) [m] to begin with, in b."""
        return np.zeros(3) if self.lever_arm is None else self.lever_arm


@dataclass(frozen=True, slots=True, eq=False)
class GlobalPose:
    """A pose in n: ``p`` (3,) [m], ``C_nb`` (3, 3), and ``covariance`` (4, 4) of position and heading."""

    t: float
    p: FloatArray
    C_nb: FloatArray
    covariance: FloatArray


class PoseGraph:
    """The graph as it grows. ``why_not`` says what is missing as long as it has not begun."""

    def __init__(self, settings: PoseGraphSettings | None = None) -> None:
        self.settings = settings or PoseGraphSettings()
        self.layout = self.settings.layout
        self.association = FixAssociation(self.settings.arm, self.settings.time_offset)
        self.why_not: str = "no GNSS fix yet"
        self.begun_at: float | None = None
        self.alignment: TrackYaw | None = None
        self._x = np.zeros((0, self.layout.size))  # one row a node, from the first node that was kept
        self._first = 0  # of the window
        self._prior: NodePrior | None = None
        self._covariance = np.zeros((self.layout.size, self.layout.size))

    def run(self, source: OdometrySource, fixes: GnssFixes) -> Iterator[GlobalPose]:
        """Yield a pose for each of the source's, from the moment of alignment; none uses anything later."""
        self.association.fixes = fixes
        for pose in source.poses():
            if (found := self.take(pose)) is not None:
                yield found

    def take(self, pose: OdometryPose) -> GlobalPose | None:
        """Take a pose, with the fixes up to it in `association`; None before the moment of alignment."""
        if pose.antenna is not None:
            self.association.lever_arm, self.association.time_offset = pose.antenna.lever, pose.antenna.time_offset
        if pose.revised:
            self.association.revise(pose.revised)
        added = self.association.add(pose)
        if self._prior is None:
            self._try_to_begin(pose, added)
        else:
            self._go_on(added > 0 or bool(pose.revised))
            self._slide(np.inf if pose.open_since is None else pose.open_since)
        return None if self._prior is None else self._latest(pose)

    @property
    def constants(self) -> tuple[FloatArray, float]:
        """The lever arm (3,) [m] and the time offset [s] as they are known now."""
        arm, offset = self.association.lever_arm, self.association.time_offset
        if not len(self._x):
            return arm, offset
        last = self._x[-1]
        return np.array(self.layout.lever_of(last, arm)), float(self.layout.offset_of(last, offset))

    @property
    def lever_std(self) -> float:
        """1 sigma [m] of the lever arm's least known component, 0 where it was given."""
        if not self.layout.lever_arm:
            return 0.0
        if self._prior is None:
            return self.settings.lever_arm_std or 0.0
        return float(np.sqrt(np.linalg.eigvalsh(self._covariance[LEVER, LEVER])[-1]))

    @property
    def offset_std(self) -> float:
        """1 sigma [s] of the time offset, 0 where it was given."""
        if not self.layout.time_offset:
            return 0.0
        if self._prior is None:
            return self.settings.time_offset_std or 0.0
        return float(np.sqrt(self._covariance[-1, -1]))

    def smoothed(self) -> tuple[Trajectory, int]:
        """Return the trajectory by all fixes, a pose a node, and how many fixes stand off as outliers."""
        if self.alignment is None:
            return Trajectory(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 4))), 0
        self.association.associate_again(self.constants[1])
        x, size = self.polished()
        C = rz(x[:, 3])[0] @ self.association.C_ob
        trajectory = Trajectory(self.association.t, x[:, :3], Rotation.from_matrix(C).as_quat())
        return trajectory, int(np.count_nonzero(size > OUTLIER_SIGMAS))

    def polished(self) -> tuple[FloatArray, FloatArray]:
        """Return the states (n, d) of the whole chain at its minimum, and the whitened length of each fix."""
        x = self._x.copy()
        nodes, terms = self.association.window(0)
        prior = self._weak_prior(x[0])
        for _ in range(MAX_ITERATIONS):
            chain, size = linearise(x, nodes, terms, prior, self.layout, self.association.lever_arm)
            step = solve_chain(chain)[0]
            x += step
            if np.abs(step).max() < 1e-4:
                break
        return x, size

    def _try_to_begin(self, pose: OdometryPose, added: int) -> None:
        """Begin when the heading of the odometry's frame is known, and place all nodes so far by it."""
        if not added:
            return
        seen = self.association.yaw_by_track() if pose.yaw_std is None else TrackYaw(0.0, pose.yaw_std, 0.0, 1.0)
        self.why_not = _why_not(seen)
        if self.why_not:
            return
        self.alignment, self.begun_at = seen, pose.t
        self._x = self._by_alignment(seen.yaw)
        self._prior = self._weak_prior(self._x[0])
        for _ in range(MAX_ITERATIONS):
            self._solve()
            if self.layout.time_offset:
                self.association.associate_again(self.constants[1])
        self._slide()

    def _by_alignment(self, yaw: float) -> FloatArray:
        p_o, terms = self.association.p_o, self.association.window(0)[1]
        x = np.zeros((len(p_o), self.layout.size))
        x[:, :3] = p_o @ rz(np.array(yaw))[0].T
        x[:, :3] += np.median(terms.z - x[terms.node, :3], axis=0)
        x[:, 3] = yaw
        if self.layout.lever_arm:
            x[:, 4:7] = self.settings.arm
        if self.layout.time_offset:
            x[:, -1] = self.settings.time_offset
        return x

    def _weak_prior(self, at: FloatArray) -> NodePrior:
        assert self.alignment is not None
        std = np.full(self.layout.size, LOOSE_POSITION_STD)
        held = self.association.yaw_std
        std[3] = max(held, 1e-6) if held is not None else np.pi  # by track, its evidence is in the window itself
        at = at.copy()
        at[3] = at[3] if held is None else 0.0
        if self.layout.lever_arm:
            std[4:7], at[4:7] = self.settings.lever_arm_std or 1.0, self.settings.arm
        if self.layout.time_offset:
            std[-1], at[-1] = self.settings.time_offset_std or 1.0, self.settings.time_offset
        return NodePrior(np.diag(std**-2.0), np.zeros(self.layout.size), at)

    def _go_on(self, has_news: bool) -> None:
        step_o, drift = self.association.last_step()
        x = self._x[-1].copy()
        R, dR = rz(x[3])
        F = np.eye(self.layout.size)
        F[:3, 3] = dR @ step_o
        x[:3] += R @ step_o
        self._x = np.vstack((self._x, x))
        self._covariance = F @ self._covariance @ F.T
        self._covariance[:4, :4] += drift
        if has_news:
            self._solve()

    def _solve(self) -> None:
        nodes, terms = self.association.window(self._first)
        assert self._prior is not None
        x = self._x[self._first :]
        chain, _ = linearise(x, nodes, terms, self._prior, self.layout, self.association.lever_arm)
        step, self._covariance = solve_chain(chain)
        x += step
        self.association.lever_arm, self.association.time_offset = self.constants

    def _slide(self, open_since: float = np.inf) -> None:
        """Eliminate what is older than the window, and has its step for good, into the prior of its first node."""
        t = self.association.t
        while t[-1] - t[self._first] > self.settings.window and t[self._first + 1] <= open_since:
            assert self._prior is not None
            nodes, terms = self.association.window(self._first, self._first + 2, fixes_of=1)
            x = self._x[self._first : self._first + 2]
            chain, _ = linearise(x, nodes, terms, self._prior, self.layout, self.association.lever_arm)
            info, gradient = eliminate(chain.D[0], chain.U[0], chain.g[0])
            self._prior = NodePrior(chain.D[1] + info, chain.g[1] + gradient, x[1].copy())
            self._first += 1

    def _latest(self, pose: OdometryPose) -> GlobalPose:
        """Return the newest pose; its covariance holds what the source alone knows of heading and antenna."""
        x, covariance = self._x[-1], self._covariance[:4, :4].copy()
        C_nb = rz(x[3])[0] @ pose.C_ob
        covariance[3, 3] += pose.own_yaw_std**2
        if pose.antenna is not None:
            covariance[:3, :3] += C_nb @ pose.antenna.covariance[:3, :3] @ C_nb.T
        return GlobalPose(pose.t, x[:3].copy(), C_nb, covariance)


def _why_not(seen: TrackYaw) -> str:
    if seen.misfit > MAX_TRACK_MISFIT:
        return (
            f"the odometry's track does not match that of GNSS (misfit {seen.misfit:.1f}, "
            f"at most {MAX_TRACK_MISFIT:g}): check time stamps and uncertainties"
        )
    if seen.std > MAX_START_YAW_STD:
        return (
            f"the heading is known to {np.degrees(min(seen.std, np.pi)):.0f} deg (u) from a track of "
            f"{seen.spread:.2f} m rms, and {np.degrees(MAX_START_YAW_STD):.0f} deg are needed: it must move "
            f"further"
        )
    return ""
