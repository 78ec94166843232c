"""Tables of means as a base model: rests in unknown attitudes, of which only the norm is known, and what it lacks.

A row is the norm of a pose less gravity. With u the direction that a pose's output shows, an effect that adds
``d`` to ``E u + D`` changes the norm by ``u' E^-1 d``: nonlinearities show where poses lie between the faces.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.calibration.solution_values import FitQuality, Solution
from procedures.diagnosis.findings import findings_of, measure_next, not_separable
from procedures.effects import EFFECTS
from procedures.effects.effect import Effect
from procedures.effects.excitation import Excitation, ExcitationStep
from procedures.errors import DoesNotFit
from procedures.evidence.candidates import Candidate, raising_does_not_fit
from procedures.evidence.linear_model import Term, fit_linear
from procedures.evidence.refit import Refit, added_at_nodes, iterate, summed
from procedures.evidence.residual_rows import KINDS, Evidence
from procedures.evidence.row_sums import NodeWeights
from procedures.frames import TRIADS
from procedures.free_positions.norm_fit import NormFit, Undetermined, fit_norm, norm_sigma
from procedures.free_positions.pose_means import SubtractedEffects
from procedures.inference.held_out_errors import left_out_groups, residual_rms
from procedures.inference.infer import infer
from procedures.inference.result import Finding, ResidualRms, TableSensor, Unnamed
from procedures.statistics.significance import log_chi2_sf

ACCELEROMETER = TRIADS.index("accelerometer")
ANGLES = 3  # rows of the fit that hold the angles between the sensors in bounds
NOTHING = CampaignFits((), None, None, None, None)


@dataclass(frozen=True, slots=True, eq=False)
class PoseTable:
    """Means ``accel`` (n, 3) [output] with 1 sigma ``std``, ``gravity`` [g], and the fit to what effects leave.

    ``added`` (n, 3) [g] is what effects add to E u + D. Where ``std`` is not stated, the poses' scatter says how
    large the noise is: ``is_std_stated``.
    """

    accel: FloatArray
    std: FloatArray
    gravity: float
    is_std_stated: bool
    fit: NormFit
    added: FloatArray

    @classmethod
    def of(cls, accel: FloatArray, std: FloatArray, gravity: float, *, is_std_stated: bool) -> Self | None:
        """Return a table; None where its poses determine no calibration, or leave nothing to test it by."""
        fit = fit_norm(accel, std, gravity)
        if isinstance(fit, Undetermined) or fit.free < 1:
            return None
        return cls(accel, std, gravity, is_std_stated, fit, np.zeros_like(accel))

    def evidence(self) -> Evidence:
        """Return a row a pose, less what effects added, and the angles' bounds."""
        fit, n = self.fit, len(self.accel)
        weight = np.hypot(self._noise(), fit.excess)
        angles = np.ones(ANGLES)
        inverse = np.linalg.inv(self._misalignment())
        weights = tuple(
            NodeWeights(slice(i, i + 1), np.ones(1), slice(i, i + 1), ACCELEROMETER, (u @ inverse)[None])
            for i, u in enumerate(self._up())
        )
        is_range = np.arange(n + ANGLES) >= n
        return Evidence(
            np.append(fit.residual, fit.fit.residual[-ANGLES:]),
            np.append(self._noise() if self.is_std_stated else weight, angles),
            fit.fit.jacobian * np.append(weight, angles)[:, None],
            np.full(n + ANGLES, ACCELEROMETER),
            np.where(is_range, KINDS.index("prior"), KINDS.index("norm")),
            np.where(is_range, -1, np.arange(n + ANGLES)),
            np.full(n + ANGLES, -1), is_range, fit.fit.x, (np.arange(len(fit.fit.x)), np.zeros(0, dtype=np.int64)),
            weights, self._seen(), np.inf if self.is_std_stated else fit.free,
        )  # fmt: skip

    def _noise(self) -> FloatArray:
        return norm_sigma(self.fit.K, self.fit.b, self.accel, self.std)

    def _misalignment(self) -> FloatArray:
        """Return E (3, 3): rows of K by their lengths."""
        found: FloatArray = self.fit.K / np.linalg.norm(self.fit.K, axis=1)[:, None]
        return found

    def _up(self) -> FloatArray:
        """Return the direction (n, 3) of the specific force in every pose, in the sensors' frame."""
        k = np.linalg.norm(self.fit.K, axis=1)
        u = np.linalg.solve(self.fit.K, (self.accel - self.added * k - self.fit.b).T).T
        found: FloatArray = u / np.linalg.norm(u, axis=1)[:, None]
        return found

    def _seen(self) -> Excitation:
        n, up = len(self.accel), self._up()
        unknown, none = np.full((n, 3), np.nan), np.full(n, np.nan)
        E, k = self._misalignment(), np.linalg.norm(self.fit.K, axis=1)
        unit, output = np.tile(np.eye(3), (n, 1, 1)), self.gravity * up @ E.T + self.fit.b / k
        steps = tuple(ExcitationStep(f"pose {i + 1}", "rest", 0, 0, "") for i in range(n))
        return Excitation(
            f=self.gravity * up, omega=unknown, magnetic=unknown, accel_output=output,
            gyro_output=unknown, change=unknown, t=none, rest_s=none, temperature=none, temperature_rate=none,
            auxiliary={}, step=np.arange(n), C_sb=unit, E_accel=np.tile(E, (n, 1, 1)), E_gyro=unit, steps=steps,
        )  # fmt: skip

    def refit(self, added: Sequence[Candidate]) -> Refit:
        """Fit calibration and effects together; `DoesNotFit` where that fails with the effects in."""
        with raising_does_not_fit(bool(added)):
            return iterate(self, type(self).evidence, type(self).without, lambda *_: NOTHING, added)

    def without(self, evidence: Evidence, added: Sequence[Candidate], values: Sequence[FloatArray]) -> Self:
        """Fit the calibration to the outputs less what effects add, with ``values`` (k,) each, in their units."""
        whole = _added(evidence, added, values)
        less = self.accel - whole * np.linalg.norm(self.fit.K, axis=1)
        fit = fit_norm(less, self.std, self.gravity)
        if isinstance(fit, Undetermined):
            raise DoesNotFit("without the effects the poses determine no calibration")
        return replace(self, fit=fit, added=whole)

    def without_effects(self, found: Refit) -> FloatArray:
        """Return the outputs (n, 3) less what the effects of a refit add."""
        last = self.without(found.evidence, found.added, found.values)
        less: FloatArray = self.accel - last.added * np.linalg.norm(last.fit.K, axis=1)
        return less

    def report(self, found: Refit) -> Solution:
        """Return how well the model fits; the calibration is in the linear fit."""
        linear = fit_linear(found.evidence, _terms(found))
        data = found.evidence.rows("norm")
        chi2 = float(np.sum(linear.white[data] ** 2 * linear.factor[data] ** 2))
        dof = max(round(float(np.sum(1 - linear.leverage[data]))), 0)
        p = float(np.exp(log_chi2_sf(chi2, dof))) if dof else 1.0
        return Solution(None, None, None, None, FitQuality(chi2, dof, p), (), np.zeros((0, 0)), None)

    def on_table(self, found: Refit) -> tuple[TableSensor, ...]:
        """Return none: nothing was turned."""
        return ()


def _added(evidence: Evidence, added: Sequence[Candidate], values: Sequence[FloatArray]) -> FloatArray:
    """Return what effects add to E u + D (n, 3) [g] with coefficients ``values`` (k,) each, in their units."""
    whole, _, _ = summed([added_at_nodes(one, evidence, c) for one, c in zip(added, values, strict=True)])
    return np.zeros((len(evidence.excitation.t), 3)) if whole is None else whole


@dataclass(frozen=True, slots=True, eq=False)
class PoseDiagnosis:
    """What a table lacks: causes with a name and without, errors before and after, every name's probability.

    ``accel`` (n, 3) [output] are the means less the likeliest effects, ``effects`` what these leave open.
    ``next_measurement`` is "" where all is named.
    """

    findings: tuple[Finding, ...]
    unnamed: tuple[Unnamed, ...]
    errors: tuple[ResidualRms, ...]
    probabilities: Mapping[str, float]
    not_separable: Mapping[str, str]
    accel: FloatArray
    effects: SubtractedEffects
    next_measurement: str


def diagnose_poses(table: PoseTable, effects: Sequence[Effect] = EFFECTS) -> PoseDiagnosis:
    """Find what the residuals of a table of means say that its calibration lacks."""
    found = infer(table, effects)
    findings, unnamed = findings_of(found)
    first, now = found.first.evidence, found.refit
    data = now.evidence.rows("norm")
    moved, covariance = found.moved
    moved = moved + found.board.evidence.x - now.evidence.x  # the last refit may stand somewhere else
    taken = [float(np.sum(fit_linear(now.evidence, terms).leverage[data])) for terms in ([], _terms(now))]
    return PoseDiagnosis(
        findings, unnamed, residual_rms(first, now, left_out_groups(first)), found.posterior.probabilities,
        not_separable(found), table.without_effects(now),
        SubtractedEffects(moved, covariance, taken[1] - taken[0]), measure_next(findings),
    )  # fmt: skip


def _terms(now: Refit) -> list[Term]:
    return [each.term for each in now.added]
