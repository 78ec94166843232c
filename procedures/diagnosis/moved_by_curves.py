"""How far the values move where something else is in the model that the data speak for as well.

What is left is not all that a cause in no catalogue does: the effects took the rest of it, and the values moved
with them. The residual tells nothing of that. So each family of `procedures.diagnosis.left_directions` is put
beside the effects, and where rows left out are foretold better with it, the values may as well be those that are
solved with it. Likewise with each effect that a finding in doubt may be instead, in its place, where it foretells
nearly as well. The farthest bounds what is not known (JCGM 100:2008, 4.3.7).
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.triad_calibration import triad_vector
from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.held_out_errors import left_out_groups
from procedures.diagnosis.left_directions import families
from procedures.diagnosis.linear_model import LinearFit, Term, fit_linear, predict_left_out
from procedures.diagnosis.model_with_effects import LoopState
from procedures.diagnosis.outdone import DECISIVE, LEAST_SIGMAS, curves_term
from procedures.diagnosis.result import Finding
from procedures.diagnosis.unexplained_residual import within_dwells
from procedures.frames import TRIADS
from procedures.uncertainty.sources import ByTriad, Unexplained

AS_WELL = 0.95  # of the ln density that a finding gains where rows are left out, from which on it may be another


def with_moved_values(state: LoopState, findings: Sequence[Finding], fit: LinearFit) -> ByTriad:
    """Return by triad what stays within the dwells, and how far what is left may have moved the values.

    ``findings`` are those of the effects adopted, in their order; ``fit`` is the last, with unwidened sigmas. Of a
    triad without an effect of its own nothing moves: all that a cause does is in its residual.
    """
    fits, left = state.now.fits, within_dwells(state.now.evidence, fit)
    joints = fits.accelerometer, None if fits.gyroscope is None else fits.gyroscope.joint
    for triad, joint, columns in zip(TRIADS, joints, state.now.evidence.columns_of, strict=True):
        if joint is not None and any(each.candidate.effect.name.startswith(f"{triad}.") for each in state.adopted):
            J = triad_vector(joint, triad, fits.accelerometer).jacobian
            models = (*_with_curves(state, fit, triad), *_with_aliases(state, findings, fit, triad))
            moved = [np.abs(J @ change[columns]) for change in _changes(state, models)]
            left[triad] = replace(left.get(triad, Unexplained()), moved=np.max([np.zeros(len(J)), *moved], axis=0))
    return left


def _changes(state: LoopState, models: Sequence[Sequence[Term]]) -> Iterator[FloatArray]:
    """Yield the change (p,) of the model's parameters with other terms than those adopted."""
    evidence = state.now.evidence
    parameters, alone = slice(evidence.A.shape[1]), fit_linear(evidence, state.beside()).theta
    for terms in models:
        yield fit_linear(evidence, terms).theta[parameters] - alone[parameters]


def _with_curves(state: LoopState, fit: LinearFit, triad: str) -> Iterator[list[Term]]:
    """Yield the terms adopted with each family of a triad beside them that foretells better."""
    evidence = state.now.evidence
    least = _foretold(state, fit) + DECISIVE
    size = max(LEAST_SIGMAS, float(np.linalg.norm(fit.white)))
    for _, of, H in families(evidence):
        if of == triad and H.any():
            terms = [*state.beside(), curves_term(H, evidence.sigma, size)]
            if _foretold_with(state, fit, terms) > least:
                yield terms


def _with_aliases(
    state: LoopState, findings: Sequence[Finding], fit: LinearFit, triad: str
) -> Iterator[list[Term]]:
    """Yield the terms adopted with what each finding of a triad may be instead, in its place, at its best way."""
    names = {each.candidate.effect.name for each in state.adopted}
    for each, finding in zip(state.adopted, findings, strict=True):
        if finding.confidence != "ambiguous" or not finding.effect.startswith(f"{triad}."):
            continue
        others, whole = state.beside(each.candidate), _foretold(state, fit)
        least = whole - (1 - AS_WELL) * (whole - _foretold_with(state, fit, others))
        for alias in sorted(set(finding.aliases) - names):
            ways = [[*others, way.term] for way in state.pool.get(alias, ()) if _is_fitted(way)]
            told = [_foretold_with(state, fit, terms) for terms in ways]
            if max(told, default=-np.inf) >= least:
                yield ways[int(np.argmax(told))]


def _is_fitted(way: Candidate) -> bool:
    return not (way.is_of_model or way.effect.is_scatter)


def _foretold_with(state: LoopState, fit: LinearFit, terms: Sequence[Term]) -> float:
    return _foretold(state, fit_linear(state.now.evidence, terms, factor=fit.factor))


def _foretold(state: LoopState, fit: LinearFit) -> float:
    """Return the log predictive density of rows left out."""
    return predict_left_out(state.now.evidence, fit, left_out_groups(state.now.evidence))[0]
