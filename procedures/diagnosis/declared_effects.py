"""Effects that somebody declared: they are in the model from the start, next to scale factor, E and bias.

Their coefficients are held to zero by their plausible range, and what else is found is found in addition to them:
they are parameters of the model. What a campaign cannot determine is not in the model, and reported.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits, fit_reduced
from procedures.calibration.reduced_steps import reduce_steps
from procedures.calibration.solution_values import Solution
from procedures.campaign.campaign import Campaign
from procedures.diagnosis.caches import clear_caches
from procedures.effects.excitation import REFERENCE_C
from procedures.effects.term.effect_of_term import TermEffect
from procedures.errors import DoesNotFit
from procedures.evidence.candidates import Candidate, Candidates, raising_does_not_fit
from procedures.evidence.linear_model import fit_linear
from procedures.evidence.refit import Refit
from procedures.evidence.residual_rows import KINDS, Evidence
from procedures.frames import TRIADS
from procedures.inference.infer import BenchModel
from procedures.inference.odds import gain
from procedures.inference.result import DeclaredEffect, TableSensor
from procedures.statistics.least_squares import left_singular

SAME = 0.98  # correlation, in addition to the model, from which on two effects are one in a design
ABSORBED = 1e-6  # of a column, below which the model holds it already


@dataclass(frozen=True, slots=True, eq=False)
class DeclaredModel:
    """A bench's model with declared effects in it; ``left_out`` says in words which are not, and why."""

    bench: BenchModel
    terms: tuple[TermEffect, ...]
    declared: tuple[Candidate, ...]
    left_out: tuple[str, ...]

    def refit(self, added: Sequence[Candidate]) -> Refit:
        """Solve both triads again; the declared effects are parameters of what comes out."""
        more = [each for each in added if not each.is_of_model]
        found, first = self.bench.refit([*self.declared, *more]), len(self.declared)
        evidence = _with_parameters(found.evidence, found.added[:first])
        undeclared = tuple(_at_rows(each, len(evidence.residual)) for each in found.added[first:])
        linear = fit_linear(evidence, [each.term for each in undeclared])
        return Refit(
            found.fits,
            evidence,
            linear,
            found.values[first:],
            undeclared,
            found.added[:first],
            found.values[:first],
        )

    def report(self, found: Refit) -> Solution:
        """Return both triads' solution; where a bias goes with temperature, at the reference."""
        solution = self.bench.report(found)
        at_reference = any("T" in term.inputs for term in self.terms)
        reference = REFERENCE_C if at_reference else solution.reference_temperature
        ends = (
            f"{each.effect.name}: {text}"
            for term, each in zip(self.terms, found.declared, strict=True)
            for text in term.at_ends(each.columns.nonlinear)
        )
        warnings = (*solution.warnings, *self.left_out, *ends)
        return replace(solution, reference_temperature=reference, warnings=warnings)

    def on_table(self, found: Refit) -> tuple[TableSensor, ...]:
        """Return none: the bench is no table."""
        return ()


def _at_rows(candidate: Candidate, rows: int) -> Candidate:
    """Return an effect whose columns H (n, k) go on with noughts: declared ranges say nothing of it."""
    term = candidate.term
    none = np.zeros((rows - len(term.H), term.H.shape[1]))
    return replace(candidate, term=replace(term, H=np.vstack((term.H, none))))


def _with_parameters(evidence: Evidence, declared: Sequence[Candidate]) -> Evidence:
    """Return the evidence with the declared effects' coefficients as parameters, and their ranges as rows."""
    H = np.hstack([each.term.H for each in declared] or [np.zeros((len(evidence.residual), 0))])
    plausible = np.concatenate([each.term.plausible for each in declared] or [np.zeros(0)])
    k, p = len(plausible), len(evidence.x)
    triad = [TRIADS.index(each.effect.name.split(".")[0]) for each in declared for _ in each.term.plausible]
    none = np.zeros(k, dtype=np.int64)
    return replace(
        evidence,
        residual=np.append(evidence.residual, np.zeros(k)), sigma=np.append(evidence.sigma, plausible),
        A=np.block([[evidence.A, -H], [np.zeros((k, p)), np.eye(k)]]),
        triad=np.append(evidence.triad, np.array(triad, dtype=np.int64)),
        kind=np.append(evidence.kind, none + KINDS.index("prior")), step=np.append(evidence.step, none - 1),
        axis=np.append(evidence.axis, none), is_range=np.append(evidence.is_range, np.ones(k, dtype=bool)),
        x=np.append(evidence.x, np.zeros(k)),
    )  # fmt: skip


def declare(bench: BenchModel, terms: Sequence[TermEffect]) -> DeclaredModel:
    """Return the model with effects in it, in their order; those that cannot be determined are not in it."""
    kept, left_out, now = list[TermEffect](), list[str](), bench.refit(())
    for term in terms:
        found = _declared(bench, now, term)
        if isinstance(found, str):
            left_out.append(f"{term.effect().name} is not used: {found}")
        else:
            now = found
            kept.append(term)
    return DeclaredModel(bench, tuple(kept), now.added, tuple(left_out))


def _declared(bench: BenchModel, now: Refit, term: TermEffect) -> Refit | str:
    """Return the model with an effect in it, or why it cannot be."""
    evidence, effect = now.evidence, term.effect()
    if missing := term.missing(evidence.excitation):
        return f"{', '.join(missing)} not recorded; its term is {', '.join(term.terms)}"
    if not term.columns(evidence.excitation):
        return f"{', '.join(term.terms)} is no finite number in this campaign"
    if not (ways := Candidates(evidence, now.fits, [effect]).get(effect.name, ())):
        return "nothing in this campaign excites it enough"
    if (one := next((each for each in now.added if are_one(evidence, ways[0], each)), None)) is not None:
        return f"in this campaign it is indistinguishable from {one.effect.name}"
    if not (determined := [found for way in ways if (found := _gain(evidence, way, now)) is not None]):
        return "the model's own parameters absorb it in this campaign"
    way = max(determined, key=lambda each: each[0])[1]
    try:
        return bench.refit([*now.added, way])
    except DoesNotFit as error:
        return str(error)


def _gain(evidence: Evidence, way: Candidate, now: Refit) -> tuple[float, Candidate] | None:
    """Return the gain of a way in which an effect may act, added to those in the model; None if these take it."""
    white = evidence.A / evidence.sigma[:, None]
    if not _complement(np.linalg.qr(white)[0], way.term.H / evidence.sigma[:, None]).shape[1]:
        return None
    try:
        with raising_does_not_fit():
            c, C = way.fit(evidence, [each.term for each in now.added]).coefficients()
            information = np.asarray(np.linalg.inv(C), dtype=np.float64)
            return gain(information, information @ c, evidence.noise_dof), way
    except DoesNotFit:
        return None


def are_one(evidence: Evidence, one: Candidate, other: Candidate) -> bool:
    """Say whether two effects are one in this design: whatever the one adds to the model, the other can."""
    Q, _ = np.linalg.qr(evidence.A / evidence.sigma[:, None])
    bases = [
        _complement(Q, each.term.H[:, : len(each.term.plausible)] / evidence.sigma[:, None])
        for each in (one, other)
    ]
    if not 0 < bases[0].shape[1] <= bases[1].shape[1]:
        return False
    common = np.linalg.svd(bases[0].T @ bases[1], compute_uv=False)
    return bool(common.min() > SAME)


def _complement(Q: FloatArray, H: FloatArray) -> FloatArray:
    """Return an orthonormal basis of what columns H (n, k) add to the columns of Q (n, p)."""
    size = np.linalg.norm(H, axis=0)
    left = H - Q @ (Q.T @ H)
    seen = np.linalg.norm(left, axis=0) > ABSORBED * np.maximum(size, 1e-300)
    U, s = left_singular(left[:, seen] / np.maximum(size[seen], 1e-300))
    basis: FloatArray = U[:, s > ABSORBED]
    return basis


def declared_effects(now: Refit) -> tuple[DeclaredEffect, ...]:
    """Return the coefficients of the declared effects in a refit of a `DeclaredModel`, with 1 sigma."""
    found, first = list[DeclaredEffect](), len(now.evidence.x) - sum(map(len, now.declared_values))
    for candidate, value in zip(now.declared, now.declared_values, strict=True):
        columns, own = candidate.columns, slice(first, first + len(value))
        std = np.sqrt(np.diag(now.linear.covariance)[own])
        linear, nonlinear = len(value) - len(columns.nonlinear), np.array(list(columns.nonlinear.values()))
        both = np.append(value[:linear], nonlinear), np.append(std[:linear], nonlinear * std[linear:])
        found.append(DeclaredEffect(candidate.effect.name, columns.coefficients, *both, candidate.effect.unit))
        first += len(value)
    return tuple(found)


@dataclass(frozen=True, slots=True, eq=False)
class DeclaredSolution:
    """A solution with declared effects in it, and their coefficients."""

    solution: Solution
    fits: CampaignFits
    effects: tuple[DeclaredEffect, ...]


@clear_caches()
def solve_declared(campaigns: Sequence[Campaign], terms: Sequence[TermEffect]) -> DeclaredSolution:
    """Solve one unit's campaigns with effects in the model.

    An effect that these campaigns cannot tell is left out, and a warning says why. Raises as
    `procedures.calibration.joint_calibration.solve`.
    """
    steps = reduce_steps(campaigns)
    model = declare(BenchModel(steps, fit_reduced(steps)), terms)
    now = model.refit(())
    return DeclaredSolution(model.report(now), now.fits, declared_effects(now))
