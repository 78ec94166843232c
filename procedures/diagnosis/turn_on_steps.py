"""What a unit switched off and on within a campaign leaves of an effect.

The rows of a fit are freed of the steps that each turn-on's bias takes
(`procedures.twelve_positions.accelerometer_fit`), with orthonormal columns Q: ``r - Q Q' r``, the model's own
columns too. An effect of columns H shows in them as ``H - Q Q' H`` (Frisch, Waugh 1933), all whitened: a bias that
one turn-on alone would have is a step, and a cube that leans in one of its two dwells may as well lean the other
way in the other.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.frames import TRIADS
from procedures.twelve_positions.accelerometer_fit import TriadFit


@dataclass(frozen=True, slots=True, eq=False)
class SteppedRows:
    """Rows of one triad, their numbers (r,), freed of ``absorbed`` (r, q); ``sigma`` (r,) whitens them."""

    rows: IntArray
    sigma: FloatArray
    absorbed: FloatArray

    def free(self, H: FloatArray) -> None:
        """Free these rows of columns H (n, k), in units of ``sigma``, of what the steps take of them."""
        taken = self.absorbed.T @ (H[self.rows] / self.sigma[:, None])
        H[self.rows] -= self.sigma[:, None] * (self.absorbed @ taken)


def stepped_rows(fits: CampaignFits, marked: Callable[..., BoolArray]) -> tuple[SteppedRows, ...]:
    """Return the rows that were freed of steps.

    ``marked`` takes kinds and a triad to marks (n,), as `Evidence.rows` does.
    """
    joints = (fits.accelerometer, fits.gyroscope.joint if fits.gyroscope is not None else None)
    found = list[SteppedRows]()
    for triad, joint in zip(TRIADS, joints, strict=True):
        if joint is not None and joint.profiled:
            parts = list(_parts(fits, joint))
            rows = [np.flatnonzero(marked(kind, triad=triad)) for kind, _, _ in parts]
            sigma = np.concatenate([std.ravel() for _, std, _ in parts])
            absorbed = np.concatenate([joint.absorbed[of_fit] for _, _, of_fit in parts])
            found.append(SteppedRows(np.concatenate(rows), sigma, absorbed))
    return tuple(found)


def _parts(fits: CampaignFits, joint: TriadFit) -> Iterator[tuple[str, FloatArray, slice]]:
    """Yield the kinds of rows that a bias shows in, the sigma that whitened them, and which rows they are."""
    dwells = 3 * len(joint.seen.dwells)
    yield "mean", joint.sigma / joint.k, slice(0, dwells)
    gyroscope = fits.gyroscope
    if gyroscope is None or joint is not gyroscope.joint:
        return
    yield "turn", gyroscope.turn_sigma / joint.k, slice(dwells, dwells + 3 * len(gyroscope.turns))
    if gyroscope.moves is not None:
        sigma = np.degrees(gyroscope.moves.sigma)[:, None] * np.ones(3)
        yield "move", sigma, gyroscope.moves.rows
