"""Whether a finding foretells what is left out better than a family of smooth curves that stands for no cause.

A name that is not the cause may take most of what the cause does. What the cause does is then still foretold
better by some curve of what it goes with: of time, of temperature, of the position before. So every finding must
outdo the families of `procedures.diagnosis.left_directions`, each in its place, of one sensor or of three. A
family pays for its many coefficients, a finding for the many ways in which it was tried.

A scatter foretells nothing: each step's draw is its own. It and a family, whose coefficients are draws of one
variance as well, are compared by their marginal likelihood, the families counted. A dead zone, a rectified rate or
an end of the range is a function of the input: a few coefficients gain more than draws of every step do.
"""

from collections.abc import Sequence, Set
from dataclasses import dataclass, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.diagnosis.bias_walk import NAME as BIAS_WALK
from procedures.diagnosis.effect_selection import AdoptedEffect
from procedures.diagnosis.equivalent_effects import STANDS_SIGMAS
from procedures.diagnosis.explained_share import share_of_fits, share_of_own_triad
from procedures.diagnosis.held_out_errors import left_out_groups
from procedures.diagnosis.left_directions import INDEPENDENT, families
from procedures.diagnosis.linear_model import LinearFit, Term, fit_linear, predict_left_out
from procedures.diagnosis.model_with_effects import LoopState
from procedures.diagnosis.result import Because, Finding, Reason
from procedures.diagnosis.scatter import MIN_MARGIN, likeliest_gain, marginal_gain
from procedures.diagnosis.walk_rivals import DRIFTS, lost_in_a_walk, triad_of, walk_in_place_of, walk_outdoes
from procedures.statistics.least_squares import left_singular

KNEE_OF_RATE = "gyroscope.counts_lost"
BENDS = ("gyroscope.scale_nonlinearity", "gyroscope.sagnac_sine")
TILT = "placement.tilt"
BLOCKS_APART = 3.0  # of a soak, within which two steps may be one
UNFADING = 3.0  # rests, beyond which a relaxation does not fade: the search for its time constant ends there
LEAST_SIGMAS = 10.0  # that a curve of a family may do to all rows together; more where the finding does more
MIN_SHARE_AS_IS = 0.1  # of the excess on rows left out, all or its triad's, that a sure finding explains
MIN_OTHER = 0.01  # of one's squares that must lie outside what the other can do, for them to be two
MIN_MARGIN_OF_A_JUMP = 5.0  # ln density by which a step in time must do better than any smooth curve of it
DECISIVE = 3.0  # ln density by which a family must do better for the cause to be none that was named


def held_against_curves(
    state: LoopState, adopted: Sequence[AdoptedEffect], findings: Sequence[Finding]
) -> tuple[tuple[Finding, ...], tuple[Reason, ...]]:
    """Return the findings, ambiguous those that explain too little or are beaten; and what speaks for no name.

    The cause has no name where a family does better by far; where the name is ambiguous anyway, or a scatter,
    where one does better at all. What has no name in one triad says nothing of the other's findings.
    """
    held, beaten, unnamed = list[Finding](), list[_Beaten](), list[tuple[AdoptedEffect, Reason]]()
    walks = [walk_outdoes(state, each) for each in adopted]
    for each, finding, walk in zip(adopted, findings, walks, strict=True):
        better = _Beaten(-np.inf, "")
        if not each.candidate.is_of_model:
            effect, was = each.candidate.effect, finding
            if effect.is_scatter:
                better, least = scatter_outdone_by(state, each), 0.0
                rival = max(walk_in_place_of(state, each), *walks)
                if better.by > -MIN_MARGIN:
                    finding = finding.doubted(Because.CURVE, better.what, better.by)
                if rival > -MIN_MARGIN:
                    finding = finding.doubted(Because.WALK)
            else:
                is_sure = finding.confidence != "ambiguous"
                groups = _with_its_like(each, adopted)
                better = max((outdone_by(state, group, is_sure=is_sure) for group in groups), key=lambda b: b.by)
                least = DECISIVE if is_sure else 0.0
                is_open = _never_fades(state, each) or _is_loose(each, finding) or _is_of_a_bend(each, adopted)
                is_lost = lost_in_a_walk(state, each)
                share = max(finding.share or 0.0, _share_as_is(state, each))
                if is_open:
                    finding = finding.doubted(Because.NOT_DETERMINED)
                    unnamed.append((each, Reason(Because.NOT_DETERMINED, effect.name)))
                if better.by > (-MIN_MARGIN_OF_A_JUMP if _in_time_with_a_jump(each, adopted) else DECISIVE):
                    finding = finding.doubted(Because.CURVE, better.what, better.by)
                if share < MIN_SHARE_AS_IS:
                    finding = finding.doubted(Because.SMALL_SHARE, value=share)
                if is_lost or walk > -MIN_MARGIN:
                    finding = _or_a_walk(finding, triad_of(effect))
                if is_lost or walk > 0:
                    unnamed.append((each, Reason(Because.WALK, was.effect)))
            if better.by > least:
                unnamed.append((each, Reason(Because.CURVE, f"{was.effect}: {better.what}", better.by)))
        held.append(finding)
        beaten.append(better)
    # Then there is a cause of no name in these triads, and a curve that does better at all may be it
    triads = {_acts_on(each) for each, _ in unnamed}
    found = [
        one.doubted(Because.CURVE, better.what, better.by)
        if better.by > 0 and _is_of_any(_acts_on(each), triads) and not _has(one, Because.CURVE)
        else one
        for each, one, better in zip(adopted, held, beaten, strict=True)
    ]
    return tuple(found), tuple(reason for _, reason in unnamed)


@dataclass(frozen=True, slots=True)
class _Beaten:
    """By how much the best family ``what`` does better [ln density]; below 0: none does."""

    by: float
    what: str


def _has(finding: Finding, code: Because) -> bool:
    return any(reason.code is code for reason in finding.reasons)


def _acts_on(adopted: AdoptedEffect) -> str:
    """Return the triad that an instrument's effect acts on; '' of bench and procedure, which both triads see."""
    effect = adopted.candidate.effect
    return effect.name.partition(".")[0] if effect.kind == "instrument" else ""


def _is_of_any(triad: str, triads: Set[str]) -> bool:
    return bool(triads) and (not triad or "" in triads or triad in triads)


def _or_a_walk(finding: Finding, triad: str) -> Finding:
    """Return what a random walk may be as well: a walk goes somewhere, and steps."""
    walk = f"{triad}.{BIAS_WALK}"
    return replace(finding, aliases=tuple(dict.fromkeys((*finding.aliases, walk)))).doubted(Because.WALK)


def _share_as_is(state: LoopState, adopted: AdoptedEffect) -> float:
    """Return the share (0 to 1) of its own triad's excess over counting noise that an effect explains."""
    evidence, candidate = state.now.evidence, adopted.candidate
    return share_of_own_triad(evidence, candidate, state.beside(candidate), left_out_groups(evidence))


def of_one_step_in_doubt(adopted: Sequence[AdoptedEffect], findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings, those in doubt that may hang on one step: what is left may be more of what they are."""
    return tuple(
        finding.doubted(Because.SINGLE_STEP)
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
    return tuple(f.doubted(Because.NEIGHBOUR) if i in doubtful else f for i, f in enumerate(findings))


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


def outdone_by(state: LoopState, group: Sequence[AdoptedEffect], *, is_sure: bool = False) -> _Beaten:
    """Return by how much the best family predicts better in effects' place [ln density]; below 0: none does.

    A family of one sensor is compared with what the effects do to that sensor, if that predicts better than all
    that they do: like with like, since either pays for each coefficient that is zero. A family that
    holds the effects' own columns is no alternative to a name that ``is_sure``: what it does besides, the global
    test looks for.
    """
    evidence, effect = state.now.evidence, group[0].candidate.effect
    inside = {id(each.candidate) for each in group}
    others = [
        each.term for each in state.adopted if not (each.candidate.is_of_model or id(each.candidate) in inside)
    ]
    as_is, left_out = np.ones(len(evidence.residual)), left_out_groups(evidence)
    triad = _acts_on(group[0])

    def predicted(terms: Sequence[Term]) -> tuple[float, LinearFit]:
        fit = fit_linear(evidence, [*others, *terms], factor=as_is)
        return predict_left_out(evidence, fit, left_out)[0], fit

    Q = fit_linear(evidence, others, factor=as_is).Q[: len(as_is)]

    def beside(H: FloatArray) -> FloatArray:
        left: FloatArray = H - Q @ (Q.T @ H)
        return left

    own = [each.term for each in group]
    named, fit = predicted(own)
    does = sum(term.H @ fit.coefficients(i - len(own))[0] for i, term in enumerate(own)) / evidence.sigma
    sigmas = max(LEAST_SIGMAS, float(np.linalg.norm(does)))
    basis, _ = np.linalg.qr(np.hstack([term.H for term in own]) / evidence.sigma[:, None])
    of_rows, best = dict[bytes, float](), _Beaten(-np.inf, "")
    for what, of, H in families(evidence):
        if triad not in {"", of} or not _is_other(H, basis):
            continue
        rows: BoolArray = np.any(H != 0, axis=1)
        there = [part for term in own if (part := _on_rows(term, rows)) is not None]
        own_there = [t.H / evidence.sigma[:, None] for t in there]
        if is_sure and there and not _is_other(beside(np.hstack(own_there)), _span(beside(H))):
            continue
        if (key := rows.tobytes()) not in of_rows:
            of_rows[key] = max(named, predicted(there)[0]) if there else named
        by = predicted([curves_term(H, evidence.sigma, sigmas)])[0] - of_rows[key]
        best = max(best, _Beaten(by, f"{of}, {what}"), key=lambda one: one.by)
    ways = len(group) * float(np.log(max(len(state.pool.get(effect.name, ())), 1)))
    return replace(best, by=best.by + ways)


def _span(H: FloatArray) -> FloatArray:
    """Return an orthonormal basis (n, m) of columns (n, k)."""
    U, size = left_singular(H)
    return U[:, size > INDEPENDENT * size[0]]


def _on_rows(term: Term, rows: BoolArray) -> Term | None:
    """Return what a term does to some rows, marked (n,); None where that is nothing."""
    H = np.where(rows[:, None], term.H, 0.0)
    used = H.any(axis=0)
    return Term(H[:, used], term.plausible[used]) if used.any() else None


def scatter_outdone_by(state: LoopState, adopted: AdoptedEffect) -> _Beaten:
    """Return by how much the best family is likelier in a scatter's place [ln likelihood]; below 0: none is."""
    evidence, candidate = state.now.evidence, adopted.candidate
    beside = state.beside(candidate)
    before = candidate.without(evidence, beside, np.ones(len(evidence.residual)))
    curves = [(f"{of}, {what}", curves_term(H, evidence.sigma, 1.0)) for what, of, H in families(evidence)]
    gains = [(likeliest_gain(evidence, before, term.H), what) for what, term in curves if term.H.shape[1]]
    if not gains:
        return _Beaten(-np.inf, "")
    gain, what = max(gains)
    return _Beaten(gain - float(np.log(len(gains))) - marginal_gain(evidence, candidate, beside), what)


def _is_other(H: FloatArray, basis: FloatArray) -> bool:
    """Say whether columns (n, k) go beyond others, orthonormal (n, m): else they are among them."""
    left = H - basis @ (basis.T @ H)
    return bool(np.sum(left**2) > MIN_OTHER * np.sum(H**2))


def curves_term(H: FloatArray, sigma: FloatArray, plausible: float) -> Term:
    """Return a family's columns ``H`` (n, k), in ``sigma`` (n,) [g, deg/s], as a term, each 1 sigma over all."""
    size = np.linalg.norm(H, axis=0)
    curves = (H * sigma[:, None])[:, size > 0] / size[size > 0]
    return Term(curves, np.full(curves.shape[1], plausible))
