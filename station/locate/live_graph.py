"""The outer graph of a run without end: renewed every half hour, so that neither memory nor time grows with it."""

from typing import TypeAlias

from procedures.arrays import FloatArray
from procedures.fusion.fusion_records import GnssFixes
from procedures.fusion.inner.inertial_window import InertialWindow
from procedures.fusion.odometry import OdometryPose
from procedures.fusion.outer.pose_graph import GlobalPose, PoseGraph, PoseGraphSettings

MAX_POSES = 36_000  # poses: half an hour
RUN_IN = 1_200  # poses that a new graph goes along before it takes over: a minute, six of its windows


class NoGraph:
    """One layer: the window holds the fixes' positions itself, as where a receiver tells nothing else."""

    lever_std = 0.0

    def __init__(self, window: InertialWindow) -> None:
        self._window = window

    def add(self, fixes: GnssFixes) -> None:
        """Leave them: the window has them."""

    def take(self, pose: OdometryPose) -> GlobalPose | None:
        """Return the window's newest pose."""
        return GlobalPose(pose.t, pose.p_o, pose.C_ob, self._window.covariance_n)

    @property
    def lever_arm(self) -> FloatArray:
        """The lever arm (3,) [m] as the window knows it."""
        arm: FloatArray = self._window.constants[:3]
        return arm


class LiveGraph:
    """Like `PoseGraph`, but fixes are added as they come."""

    def __init__(self, settings: PoseGraphSettings, renewed: int = MAX_POSES, run_in: int = RUN_IN) -> None:
        self._settings, self._renewed, self._run_in = settings, renewed, run_in
        self._graph = PoseGraph(settings)
        self._heir: PoseGraph | None = None
        self._poses = 0

    def add(self, fixes: GnssFixes) -> None:
        """Take fixes that come after all so far."""
        for graph in (self._graph, self._heir) if self._heir is not None else (self._graph,):
            known = graph.association.fixes
            graph.association.fixes = fixes if known is None else known.followed_by(fixes)

    def take(self, pose: OdometryPose) -> GlobalPose | None:
        """Return a pose in n; None before the moment of alignment."""
        self._poses += 1
        found = self._graph.take(pose)
        if self._heir is not None and self._heir.association.fixes is not None:
            self._heir.take(pose)
        self._renew()
        return found

    @property
    def lever_arm(self) -> FloatArray:
        """The lever arm (3,) [m] as it is known now."""
        return self._graph.constants[0]

    @property
    def lever_std(self) -> float:
        """1 sigma [m] of its least known component, 0 where it was given."""
        return self._graph.lever_std

    def _renew(self) -> None:
        """Have an heir begin, or take over once it has run in."""
        if self._heir is None:
            if self._poses >= self._renewed:
                self._heir = PoseGraph(self._settings)
        elif self._poses >= self._renewed + self._run_in and self._heir.begun_at is not None:
            self._graph, self._heir, self._poses = self._heir, None, self._run_in


Graph: TypeAlias = LiveGraph | NoGraph  # what makes a window's poses those in n
