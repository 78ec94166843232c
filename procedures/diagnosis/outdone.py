"""Whether a finding foretells what is left out better than a family of smooth curves that stands for no cause.

A name that is not the cause may take most of what the cause does. What the cause does is then still foretold
better by some curve of what it goes with: of time, of temperature, of the position before. So every finding must
outdo the families of `procedures.diagnosis.left_directions`, each in its place, of one sensor or of three. A
family pays for its many coefficients, a finding for the many ways in which it was tried.

A scatter foretells nothing: each step's draw is its own. It and a family, whose coefficients are draws of one
variance as well, are compared by their marginal likelihood, the families counted. A dead zone, a rectified rate or
an end of the range is a function of the input: a few coefficients gain more than draws of every step do.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.diagnosis.effect_selection import AdoptedEffect
from procedures.diagnosis.explained_share import held_out_excess
from procedures.diagnosis.held_out_errors import left_out_groups
from procedures.diagnosis.left_directions import families
from procedures.diagnosis.linear_model import LinearFit, Term, fit_linear, predict_left_out
from procedures.diagnosis.model_with_effects import LoopState
from procedures.diagnosis.result import Finding
from procedures.diagnosis.scatter import MIN_MARGIN, likeliest_gain, marginal_gain

LEAST_SIGMAS = 10.0  # that a curve of a family may do to all rows together; more where the finding does more
MIN_SHARE_AS_IS = 0.1  # of the excess over counting noise that a finding must explain on rows left out to be sure
MIN_OTHER = 0.01  # of a family's squares that must lie outside what the finding itself can do
MIN_MARGIN_OF_A_JUMP = 5.0  # ln density by which a step in time must do better than any smooth curve of it
DECISIVE = 3.0  # ln density by which a family must do better for the cause to be none that was named


def held_against_curves(
    state: LoopState, adopted: Sequence[AdoptedEffect], findings: Sequence[Finding]
) -> tuple[tuple[Finding, ...], bool]:
    """Return the findings, in doubt those that explain too little or are outdone; and whether one is by far."""
    held, is_unexplained = list[Finding](), False
    for each, finding in zip(adopted, findings, strict=True):
        if each.candidate.is_of_model:
            held.append(finding)
            continue
        if each.candidate.effect.is_scatter:
            better = scatter_outdone_by(state, each)
            is_unexplained |= better > DECISIVE
            held.append(replace(finding, confidence="ambiguous") if better > -MIN_MARGIN else finding)
            continue
        better = max(outdone_by(state, group) for group in _with_its_like(each, adopted))
        is_thin = finding.share < MIN_SHARE_AS_IS
        is_unexplained |= better > DECISIVE
        most = -MIN_MARGIN_OF_A_JUMP if each.candidate.effect.name.endswith(".jump") else DECISIVE
        held.append(replace(finding, confidence="ambiguous") if better > most or is_thin else finding)
    return tuple(held), is_unexplained


def share_foretold(state: LoopState, adopted: AdoptedEffect) -> float:
    """Return the share (0 to 1) of the excess, where rows are left out, that an effect explains beside all others.

    By the rows' sigma as the fit with it has it: where scatter is the yardstick, scatter is no excess.
    """
    evidence, candidate = state.now.evidence, adopted.candidate
    others, left_out = state.beside(candidate), left_out_groups(evidence)
    fit = candidate.fit(evidence, others)
    without = held_out_excess(evidence, candidate.without(evidence, others, fit.factor), left_out)
    return 1 - min(held_out_excess(evidence, fit, left_out) / without, 1.0) if without > 0 else 1.0


def _with_its_like(one: AdoptedEffect, adopted: Sequence[AdoptedEffect]) -> list[list[AdoptedEffect]]:
    """Return an effect alone, and with all others of the name: several jumps are a staircase, not a cause."""
    name = one.candidate.effect.name
    like = [each for each in adopted if each.candidate.effect.name == name]
    return [[one]] if len(like) == 1 else [[one], like]


def outdone_by(state: LoopState, group: Sequence[AdoptedEffect]) -> float:
    """Return by how much the best family foretells better in effects' place [ln density]; below 0: none does."""
    evidence, effect = state.now.evidence, group[0].candidate.effect
    inside = {id(each.candidate) for each in group}
    others = [
        each.term for each in state.adopted if not (each.candidate.is_of_model or id(each.candidate) in inside)
    ]
    as_is, left_out = np.ones(len(evidence.residual)), left_out_groups(evidence)
    triad = effect.name.split(".")[0] if effect.kind == "instrument" else ""

    def foretold(terms: Sequence[Term]) -> tuple[float, LinearFit]:
        fit = fit_linear(evidence, [*others, *terms], factor=as_is)
        return predict_left_out(evidence, fit, left_out)[0], fit

    own = [each.term for each in group]
    named, fit = foretold(own)
    named -= len(group) * float(np.log(max(len(state.pool.get(effect.name, ())), 1)))
    does = sum(term.H @ fit.coefficients(i - len(own))[0] for i, term in enumerate(own)) / evidence.sigma
    sigmas = max(LEAST_SIGMAS, float(np.linalg.norm(does)))
    basis, _ = np.linalg.qr(np.hstack([term.H for term in own]) / evidence.sigma[:, None])
    terms = (
        _term(H, evidence.sigma, sigmas)
        for _, of, H in families(evidence)
        if triad in {"", of} and _is_other(H, basis)
    )
    return max((foretold([term])[0] - named for term in terms), default=-np.inf)


def scatter_outdone_by(state: LoopState, adopted: AdoptedEffect) -> float:
    """Return by how much the best family is likelier in a scatter's place [ln likelihood]; below 0: none is."""
    evidence, candidate = state.now.evidence, adopted.candidate
    beside = state.beside(candidate)
    before = candidate.without(evidence, beside, np.ones(len(evidence.residual)))
    curves = [_term(H, evidence.sigma, 1.0) for _, _, H in families(evidence)]
    gains = [likeliest_gain(evidence, before, term.H) for term in curves if term.H.shape[1]]
    if not gains:
        return -np.inf
    return max(gains) - float(np.log(len(gains))) - marginal_gain(evidence, candidate, beside)


def _is_other(H: FloatArray, basis: FloatArray) -> bool:
    """Say whether a family's columns (n, k) go beyond the effects' own, orthonormal (n, m): else it is they."""
    left = H - basis @ (basis.T @ H)
    return bool(np.sum(left**2) > MIN_OTHER * np.sum(H**2))


def _term(H: FloatArray, sigma: FloatArray, plausible: float) -> Term:
    """Return a family's columns (n, k) in sigmas as a term, each of 1 sigma over all rows."""
    size = np.linalg.norm(H, axis=0)
    curves = (H * sigma[:, None])[:, size > 0] / size[size > 0]
    return Term(curves, np.full(curves.shape[1], plausible))
