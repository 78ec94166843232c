"""What the global test leaves unexplained, once the scatter that was found is in.

A triad whose whitened squares, scatter included, still fail the test at `DOUBTFUL_P_VALUE` is taken to have
observations too certain by one factor (Birge, Phys. Rev. 40, 1932): squares over degrees of freedom, less one,
is the variance every observation lacks. Below that nothing is added, unless a diagnosis says that something is
left, and then what it found within the dwells besides. On a unit that the model describes the test fails once
in a hundred times, so that the mean of what is added is under a hundredth of the variance of the observations.
"""

import numpy as np
from scipy.special import gammaincc

from procedures.arrays import BoolArray
from procedures.calibration.solution_values import DOUBTFUL_P_VALUE
from procedures.dwells_and_turns.twelve_position import TriadFit
from procedures.uncertainty import sources
from procedures.uncertainty.given_values import GivenValues
from procedures.uncertainty.sources import Shares, SourceCell
from procedures.uncertainty.temperature import TemperatureEffect


def unexplained(
    triad: str,
    chi2: float,
    dof: int,
    observed: BoolArray,
    temperature: TemperatureEffect | None,
    is_left: bool = False,
) -> Shares:
    """Return the variance (n,) that the rows ``observed`` (n,) lack, none where the squares pass the test.

    What ``temperature`` takes of the squares is explained by it and counted there. ``is_left``: a diagnosis says
    that the test fails, whatever this one of all squares together says.
    """
    if temperature is not None:
        chi2, dof = chi2 - temperature.chi2, dof - temperature.rank
    if dof <= 0 or chi2 <= dof or (not is_left and gammaincc(dof / 2, chi2 / 2) >= DOUBTFUL_P_VALUE):
        return {}
    ratio = chi2 / dof
    cell = SourceCell(sources.UNEXPLAINED, triad, max(dof * (1 - 1 / ratio) ** 2, 1.0))
    return {cell: (ratio - 1) * np.where(observed, 1.0, 0.0)}


def unexplained_within(triad: str, joint: TriadFit, dof: int, squares: float) -> Shares:
    """Return the variance (n,) that the rows of dwells lack by what wanders within them.

    ``squares`` of the counting noise of their means are added to each, as well known as the fit's ``dof`` tell.
    """
    m = 3 * len(joint.seen.dwells)
    if squares <= 0 or not m:
        return {}
    share = np.zeros(len(joint.fit.residual))
    share[:m] = squares * ((joint.expected / joint.sigma) ** 2).ravel()
    return {SourceCell(sources.UNEXPLAINED, triad, max(dof * (squares / (1 + squares)) ** 2, 1.0)): share}


def moved_values(triad: str, inputs: GivenValues) -> Shares:
    """Return the variance (15,) of k, E and D, each in its unit, for what effects took that is not theirs.

    Between bounds any change is as likely as another (JCGM 100:2008, 4.3.7).
    """
    left = (inputs.unexplained or {}).get(triad)
    if left is None or left.moved is None:
        return {}
    return {SourceCell(sources.UNEXPLAINED, f"{triad} moved"): left.moved**2 / 3}
