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
from procedures.diagnosis.bias_walk import NAME as BIAS_WALK
from procedures.diagnosis.effect_selection import AdoptedEffect
from procedures.diagnosis.equivalent_effects import STANDS_SIGMAS
from procedures.diagnosis.explained_share import share_of_fits, share_of_own_triad
from procedures.diagnosis.held_out_errors import left_out_groups
from procedures.diagnosis.left_directions import families
from procedures.diagnosis.linear_model import LinearFit, Term, fit_linear, predict_left_out
from procedures.diagnosis.model_with_effects import LoopState
from procedures.diagnosis.result import Finding
from procedures.diagnosis.scatter import MIN_MARGIN, likeliest_gain, marginal_gain
from procedures.diagnosis.walk_rivals import DRIFTS, lost_in_a_walk, triad_of, walk_in_place_of, walk_outdoes

KNEE_OF_RATE = "gyroscope.counts_lost"
BENDS = ("gyroscope.scale_nonlinearity", "gyroscope.sagnac_sine")
TILT = "placement.tilt"
BLOCKS_APART = 3.0  # of a soak, within which two steps may be one
UNFADING = 3.0  # rests, beyond which a relaxation does not fade: the search for its time constant ends there
LEAST_SIGMAS = 10.0  # that a curve of a family may do to all rows together; more where the finding does more
MIN_SHARE_AS_IS = 0.1  # of the excess on rows left out, all or its triad's, that a sure finding explains
MIN_OTHER = 0.01  # of a family's squares that must lie outside what the finding itself can do
MIN_MARGIN_OF_A_JUMP = 5.0  # ln density by which a step in time must do better than any smooth curve of it
DECISIVE = 3.0  # ln density by which a family must do better for the cause to be none that was named


def held_against_curves(
    state: LoopState, adopted: Sequence[AdoptedEffect], findings: Sequence[Finding]
) -> tuple[tuple[Finding, ...], bool]:
    """Return the findings, in doubt those that explain too little or are outdone; and whether one is no cause.

    It is none where a family does better by far; where the name is in doubt anyway, or a scatter, where one does
    better at all.
    """
    held, outdone, is_unexplained = list[Finding](), list[float](), False
    walks = [walk_outdoes(state, each) for each in adopted]
    for each, finding, walk in zip(adopted, findings, walks, strict=True):
        if each.candidate.is_of_model:
            held.append(finding)
            outdone.append(-np.inf)
            continue
        if each.candidate.effect.is_scatter:
            better = scatter_outdone_by(state, each)
            is_unexplained |= better > 0
            outdone.append(better)
            rival = max(better, *walks, walk_in_place_of(state, each))
            held.append(replace(finding, confidence="ambiguous") if rival > -MIN_MARGIN else finding)
            continue
        better = max(outdone_by(state, group) for group in _with_its_like(each, adopted))
        is_none = _never_fades(state, each) or _is_loose(each, finding) or _is_of_a_bend(each, adopted)
        better = np.inf if is_none else better
        is_lost = lost_in_a_walk(state, each)
        outdone.append(better)
        is_thin = max(finding.share, _share_as_is(state, each)) < MIN_SHARE_AS_IS
        is_unexplained |= is_lost or walk > 0 or better > (0 if finding.confidence == "ambiguous" else DECISIVE)
        most = -MIN_MARGIN_OF_A_JUMP if _in_time_with_a_jump(each, adopted) else DECISIVE
        if is_lost or walk > -MIN_MARGIN:
            finding = _or_a_walk(finding, triad_of(each.candidate.effect))
        held.append(replace(finding, confidence="ambiguous") if better > most or is_thin else finding)
    if is_unexplained:  # then there is a cause of no name, and a curve that does better at all may be it
        held = [
            replace(one, confidence="ambiguous") if better > 0 else one
            for one, better in zip(held, outdone, strict=True)
        ]
    return tuple(held), is_unexplained


def _or_a_walk(finding: Finding, triad: str) -> Finding:
    """Return what a random walk may be as well: a walk goes somewhere, and steps."""
    walk = f"{triad}.{BIAS_WALK}"
    return replace(finding, confidence="ambiguous", aliases=tuple(dict.fromkeys((*finding.aliases, walk))))


def _share_as_is(state: LoopState, adopted: AdoptedEffect) -> float:
    """Return the share (0 to 1) of its own triad's excess over counting noise that an effect explains."""
    evidence, candidate = state.now.evidence, adopted.candidate
    return share_of_own_triad(evidence, candidate, state.beside(candidate), left_out_groups(evidence))


def of_one_step_in_doubt(adopted: Sequence[AdoptedEffect], findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings, those in doubt that may hang on one step: what is left may be more of what they are."""
    return tuple(
        replace(finding, confidence="ambiguous")
        if each.candidate.effect.may_hang_on_a_step or "position" in each.candidate.columns.where
        else finding
        for each, finding in zip(adopted, findings, strict=True)
    )


def steps_beside_steps_in_doubt(
    state: LoopState, adopted: Sequence[AdoptedEffect], findings: Sequence[Finding]
) -> tuple[Finding, ...]:
    """Return findings, those in doubt that are steps of one soak within some blocks of another one.

    A step is tried at a few moments of a block: one between them is made of two, of which neither is.
    """
    seen = state.now.evidence.excitation
    lengths = [float(np.ptp(seen.t[seen.step == n])) for n, step in enumerate(seen.steps) if step.kind == "soak"]
    near = BLOCKS_APART * max(lengths, default=0.0)
    steps = [(i, one) for i, one in enumerate(adopted) if _is_within_a_recording(one)]

    def is_beside(one: AdoptedEffect, other: AdoptedEffect) -> bool:
        ours, theirs = one.candidate.columns.where, other.candidate.columns.where
        at, then = (float(str(where["after_s"])) for where in (ours, theirs))
        return ours["in"] == theirs["in"] and abs(at - then) < near

    doubtful = {i for i, one in steps for j, other in steps if i != j and is_beside(one, other)}
    return tuple(replace(f, confidence="ambiguous") if i in doubtful else f for i, f in enumerate(findings))


def _is_within_a_recording(one: AdoptedEffect) -> bool:
    where = one.candidate.columns.where
    return one.candidate.effect.name.endswith((".jump", TILT)) and {"in", "after_s"} <= set(where)


def share_foretold(state: LoopState, adopted: AdoptedEffect) -> float:
    """Return the share (0 to 1) of the excess, where rows are left out, that an effect explains beside all others.

    By the rows' sigma as the fit with it has it: where scatter is the yardstick, scatter is no excess.
    """
    evidence, candidate = state.now.evidence, adopted.candidate
    others = state.beside(candidate)
    fit = candidate.fit(evidence, others)
    before = candidate.without(evidence, others, fit.factor)
    share = share_of_fits(evidence, before, fit, left_out_groups(evidence))
    return 1.0 if share is None else share


def _with_its_like(one: AdoptedEffect, adopted: Sequence[AdoptedEffect]) -> list[list[AdoptedEffect]]:
    """Return an effect alone, and with all others of the name: several jumps are a staircase, not a cause.

    A jump and a drift of one triad are a curve of time that neither is.
    """
    name = one.candidate.effect.name
    like = [each for each in adopted if each.candidate.effect.name == name]
    found = [[one]] if len(like) == 1 else [[one], like]
    if _in_time_with_a_jump(one, adopted):
        both = [each for each in adopted if each.candidate.effect.name in _in_time(one)]
        found += [both] if len(both) > len(like) else []
    return found


def _in_time(one: AdoptedEffect) -> tuple[str, ...]:
    """Return the names of what acts on an effect's triad by time alone."""
    triad = triad_of(one.candidate.effect)
    return f"{triad}.jump", TILT, *(f"{triad}{name}" for name in DRIFTS)


def _in_time_with_a_jump(one: AdoptedEffect, adopted: Sequence[AdoptedEffect]) -> bool:
    """Say whether an effect is a jump, or a drift beside one."""
    steps = _in_time(one)[:2]
    return one.candidate.effect.name in _in_time(one) and any(
        each.candidate.effect.name in steps for each in adopted
    )


def _never_fades(state: LoopState, one: AdoptedEffect) -> bool:
    """Say whether a relaxation lasts by far longer than any rest: what fades nowhere is the position before."""
    seen = state.now.evidence.excitation
    if not one.candidate.effect.name.endswith(".relaxation"):
        return False
    resting = np.isin([step.kind for step in seen.steps], ("dwell", "rest"))[seen.step]
    return bool(one.candidate.columns.tau_s > UNFADING * float(np.max(seen.rest_s[resting], initial=0.0)))


def _is_of_a_bend(one: AdoptedEffect, adopted: Sequence[AdoptedEffect]) -> bool:
    """Say whether a knee stands beside another bend of the scale factor: both are a curve that neither is."""
    bends = {each.candidate.effect.name for each in adopted} & {KNEE_OF_RATE, *BENDS}
    return one.candidate.effect.name in bends and KNEE_OF_RATE in bends and len(bends) > 1


def _is_loose(one: AdoptedEffect, finding: Finding) -> bool:
    """Say whether what settles may as well go on with time, or no knee is told: it is not far from nought."""
    may_be = one.candidate.effect.name.endswith(("_settling", KNEE_OF_RATE))
    return may_be and bool(finding.value[-1] < STANDS_SIGMAS * finding.std[-1])


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
        curves_term(H, evidence.sigma, sigmas)
        for _, of, H in families(evidence)
        if triad in {"", of} and _is_other(H, basis)
    )
    return max((foretold([term])[0] - named for term in terms), default=-np.inf)


def scatter_outdone_by(state: LoopState, adopted: AdoptedEffect) -> float:
    """Return by how much the best family is likelier in a scatter's place [ln likelihood]; below 0: none is."""
    evidence, candidate = state.now.evidence, adopted.candidate
    beside = state.beside(candidate)
    before = candidate.without(evidence, beside, np.ones(len(evidence.residual)))
    curves = [curves_term(H, evidence.sigma, 1.0) for _, _, H in families(evidence)]
    gains = [likeliest_gain(evidence, before, term.H) for term in curves if term.H.shape[1]]
    if not gains:
        return -np.inf
    return max(gains) - float(np.log(len(gains))) - marginal_gain(evidence, candidate, beside)


def _is_other(H: FloatArray, basis: FloatArray) -> bool:
    """Say whether a family's columns (n, k) go beyond the effects' own, orthonormal (n, m): else it is they."""
    left = H - basis @ (basis.T @ H)
    return bool(np.sum(left**2) > MIN_OTHER * np.sum(H**2))


def curves_term(H: FloatArray, sigma: FloatArray, plausible: float) -> Term:
    """Return a family's columns ``H`` (n, k), in ``sigma`` (n,) [g, deg/s], as a term, each 1 sigma over all."""
    size = np.linalg.norm(H, axis=0)
    curves = (H * sigma[:, None])[:, size > 0] / size[size > 0]
    return Term(curves, np.full(curves.shape[1], plausible))
