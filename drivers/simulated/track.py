"""Where a simulated vehicle goes: straight lines between points in time, level East-North-Up [m] from its site."""

from dataclasses import dataclass
from io import StringIO

import numpy as np

from drivers.simulated.errors import TruthRefused
from procedures.arrays import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """Points ``enu`` (n, 3) [m] at times ``t`` (n,) [s]; it stands at the first before and at the last after."""

    t: FloatArray
    enu: FloatArray

    def __post_init__(self) -> None:
        if len(self.t) < 2 or self.enu.shape != (len(self.t), 3) or not np.all(np.diff(self.t) > 0):
            raise TruthRefused(
                f"a track of shape {self.enu.shape}", "two rows or more t_s,e_m,n_m,u_m, t_s increasing"
            )

    def position(self, t: float) -> FloatArray:
        """Return the place (3,) [m] at time ``t`` [s]."""
        return np.array([np.interp(t, self.t, self.enu[:, i]) for i in range(3)])

    def velocity(self, t: float) -> FloatArray:
        """Return the velocity (3,) [m/s] at time ``t`` [s]."""
        leg = int(np.searchsorted(self.t, t, side="right")) - 1
        if not 0 <= leg < len(self.t) - 1:
            return np.zeros(3)
        v: FloatArray = (self.enu[leg + 1] - self.enu[leg]) / (self.t[leg + 1] - self.t[leg])
        return v


def load_track(text: str) -> Track:
    """Return the track of a CSV text ``t_s,e_m,n_m,u_m``; raise `TruthRefused` where it is none."""
    try:
        rows = np.loadtxt(StringIO(text), delimiter=",", skiprows=1, ndmin=2)
    except ValueError as error:
        raise TruthRefused(str(error), "rows t_s,e_m,n_m,u_m after a header") from error
    if rows.shape[1] != 4:
        raise TruthRefused(f"{rows.shape[1]} columns", "t_s,e_m,n_m,u_m")
    return Track(rows[:, 0], rows[:, 1:])
