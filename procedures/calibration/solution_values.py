"""What a solve returns: values with 1 sigma, their covariance, the residual and what stayed open."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import chdtri

from procedures.arrays import FloatArray
from procedures.calibration.undetectable_tilt import UndetectableTilt

DOUBTFUL_P_VALUE = 0.01  # p-value of the global test below which the sigmas are reported as ambiguous


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """A value, its 1 sigma of the same shape, and its unit as written in files."""

    value: FloatArray
    std: FloatArray
    unit: str

    def widened(self, shift: FloatArray) -> "Estimate":
        """Return it with a ``shift`` (...), shaped like the value and in its unit, next to its sigma."""
        return replace(self, std=np.hypot(self.std, shift))


@dataclass(frozen=True, slots=True, eq=False)
class TriadCalibration:
    """A triad's ``N = k * (E u + D)``: scale factor (3,), misalignment (3, 3), bias (3,), IMU axes.

    ``bias`` is the joint estimate. ``bias_12_position`` and ``bias_two_direction`` are the estimators of
    Yao, Hu, He 2018, eq. (8) and (9)-(11), with counting noise only; None where their positions are missing.
    """

    scale_factor: Estimate
    misalignment: Estimate
    bias: Estimate
    bias_12_position: Estimate | None = None
    bias_two_direction: Estimate | None = None

    @property
    def vector(self) -> FloatArray:
        """Scale factor (3), misalignment (9) by rows and bias (3) in one (15,), each in its unit."""
        return np.concatenate((self.scale_factor.value, self.misalignment.value.ravel(), self.bias.value))

    def widened(self, shift: FloatArray) -> "TriadCalibration":
        """Return it with a ``shift`` (15,) of `vector`, in its units, next to the sigmas."""
        return replace(
            self,
            scale_factor=self.scale_factor.widened(shift[:3]),
            misalignment=self.misalignment.widened(shift[3:12].reshape(3, 3)),
            bias=self.bias.widened(shift[12:]),
        )


@dataclass(frozen=True, slots=True, eq=False)
class StepResidual:
    """Observed minus modelled output of one step and triad (3,), its 1 sigma (3,), in ``unit``.

    Units are g, deg/h, deg (turns) and arcsec (moves). ``sigma`` includes what the fit absorbs: residual / sigma
    is a unit normal if the model is right.
    """

    name: str
    kind: str  # "dwell", "turn" or "move"
    triad: str  # "accelerometer" or "gyroscope"
    position: int
    residual: FloatArray
    sigma: FloatArray
    unit: str


@dataclass(frozen=True, slots=True, eq=False)
class FitQuality:
    """The global test of a solve: rms per triad, chi-square, degrees of freedom, p-value."""

    chi2: float
    dof: int
    p_value: float
    accelerometer_rms_g: float | None = None
    gyroscope_rms_dph: float | None = None

    @property
    def noticed_sigmas(self) -> float:
        """By how many sigmas a thing alone has to be off for the test to fail every second time."""
        dof = max(self.dof, 1)
        return float(np.sqrt(chdtri(dof, DOUBTFUL_P_VALUE) - dof))


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """A calibration with honest uncertainty.

    ``slab_tilt`` (2,) [rad]: East and North components of the up vector seen from the slab.
    ``parallelism`` (3, 2) [rad]: rows face pair x, y, z, columns the two other axes in x, y, z order, the sum of
    both faces' up tilts. ``names`` label the rows of ``covariance``: ``accelerometer.scale_factor.x``,
    ``gyroscope.misalignment.xy``, ``slab.tilt.east``, ``fixture.parallelism.x.y`` ... ``turned_off`` names the
    dwells that surely stood turned against the marks. ``undetectable_tilts`` are those of the dwells whose seating
    was not found to be off and whose tilt changes a result; none without dwells of accelerometers, or when rotated
    freely.
    """

    accelerometer: TriadCalibration | None
    gyroscope: TriadCalibration | None
    slab_tilt: Estimate | None
    parallelism: Estimate | None
    quality: FitQuality
    names: tuple[str, ...]
    covariance: FloatArray
    reference_temperature: float | None
    residuals: tuple[StepResidual, ...] = ()
    not_observable: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    unused_steps: tuple[str, ...] = ()
    turned_off: tuple[str, ...] = ()
    undetectable_tilts: tuple[UndetectableTilt, ...] = ()
