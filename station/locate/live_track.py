"""The way gone so far, as a map draws it: evenly thinned, so that it never grows beyond a few thousand points."""

import numpy as np

from procedures.arrays import FloatArray

MAX_POINTS = 2000  # points
INITIAL_SPACING_M = 0.2  # m between two points, at first; twice as much each time it is thinned
MAX_DRAWN_OUTLIERS = 200  # outliers that are drawn
Place = tuple[float, float]


class LiveTrack:
    """``points`` and outlying fixes ``far``, each East and North [m]; ``outliers`` counts all of them."""

    def __init__(self) -> None:
        self._points: list[Place] = []
        self._step, self.outliers = INITIAL_SPACING_M, 0
        self.points: tuple[Place, ...] = ()
        self.far: tuple[Place, ...] = ()

    def add(self, p: FloatArray) -> None:
        """Go on to a place (3,) [m]."""
        here = float(p[0]), float(p[1])
        if self._points and np.hypot(here[0] - self._points[-1][0], here[1] - self._points[-1][1]) < self._step:
            return
        self._points.append(here)
        if len(self._points) > MAX_POINTS:
            del self._points[1::2]
            self._step *= 2
        self.points = tuple(self._points)

    def add_outlier(self, p: FloatArray) -> None:
        """Count a fix at a place (3,) [m] that is none of the unit's."""
        self.outliers += 1
        self.far = (*self.far, (float(p[0]), float(p[1])))[-MAX_DRAWN_OUTLIERS:]
