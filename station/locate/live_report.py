"""What is told of a live location: place, heading, their sigmas, the way gone, and which fixes stand off."""

import numpy as np

from procedures.arrays import FloatArray
from procedures.earth.geodesy import LocalLevel
from procedures.fusion.outer.pose_graph import OUTLIER_SIGMAS, GlobalPose
from station.locate.live_fixes import LiveFixes
from station.locate.location import Location

MIN_LEVEL_PART = 0.1  # of forward's length across the vertical, below which it has no heading
MAX_POINTS = 2000  # points
INITIAL_SPACING_M = 0.2  # m between two points, at first; twice as much each time it is thinned
MAX_DRAWN_OUTLIERS = 200  # outliers that are drawn
Place = tuple[float, float]


class LocationReport:
    """``ahead`` (3,) is forward in IMU axes. The way gone is evenly thinned, as a map draws it."""

    def __init__(self, ahead: FloatArray) -> None:
        self._ahead = ahead
        self._points, self._track = list[Place](), tuple[Place, ...]()
        self._step, self._outliers = INITIAL_SPACING_M, 0
        self._far: tuple[Place, ...] = ()
        self.begin_anew()

    def begin_anew(self) -> None:
        """Go on with the same track."""
        self._std: FloatArray = np.zeros(3)  # of the last place

    def look_at(self, place: FloatArray, std: float, fix: FloatArray) -> None:
        """Count a fix (3,) that stands off the antenna's place (3,) by more than chance and what was uncertain."""
        if np.linalg.norm((fix - place) / np.hypot(std, self._std)) > OUTLIER_SIGMAS:
            self._outliers += 1
            self._far = (*self._far, (float(fix[0]), float(fix[1])))[-MAX_DRAWN_OUTLIERS:]

    def location(self, pose: GlobalPose, velocity: FloatArray, origin: LocalLevel, fixes: LiveFixes) -> Location:
        """Return what is known at a pose, with its ``velocity`` (3,) [m/s].

        The place is no better than the receiver says of itself: its errors last for minutes, they do not average.
        """
        self._draw(float(pose.p[0]), float(pose.p[1]))
        std = np.sqrt(np.diag(pose.covariance))
        self._std = std[:3]
        ahead = pose.C_nb @ self._ahead
        is_level = bool(np.hypot(*ahead[:2]) > MIN_LEVEL_PART)
        latitude, longitude, height = origin.geodetic(pose.p)
        return Location(
            is_located=True, t=pose.t, enu=_three(pose.p), enu_std=_three(np.hypot(std[:3], fixes.std)),
            velocity=_three(velocity),
            heading=float(np.degrees(np.arctan2(ahead[0], ahead[1])) % 360) if is_level else None,
            heading_std=float(np.degrees(std[3])),
            latitude=float(np.degrees(latitude)), longitude=float(np.degrees(longitude)), height=height,
            fixes=fixes.count, outliers=self._outliers, fix_age=pose.t - fixes.newest_taken,
            track=self._track, far=self._far,
        )  # fmt: skip

    def _draw(self, east: float, north: float) -> None:
        if self._points and np.hypot(east - self._points[-1][0], north - self._points[-1][1]) < self._step:
            return
        self._points.append((east, north))
        if len(self._points) > MAX_POINTS:
            del self._points[1::2]
            self._step *= 2
        self._track = tuple(self._points)


def _three(vector: FloatArray) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z
