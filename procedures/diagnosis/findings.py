"""What a posterior says as findings: names with their probability, sizes, and the error held out without each."""

from collections.abc import Mapping, Sequence

import numpy as np

from procedures.arrays import BoolArray, FloatArray, IntArray
from procedures.effects.effect import Effect
from procedures.evidence.candidates import Candidate
from procedures.evidence.linear_model import fit_linear, predict_left_out
from procedures.evidence.refit import Refit
from procedures.inference import priors
from procedures.inference.held_out_errors import errors_of_fits, left_out_groups
from procedures.inference.infer import Inferred
from procedures.inference.posterior import Cause, Coefficients
from procedures.inference.result import Finding, ResidualRms, Unnamed
from procedures.positions import FACES


def findings_of(found: Inferred) -> tuple[tuple[Finding, ...], tuple[Unnamed, ...]]:
    """Return the causes that have a likely name, and those that have none."""
    named, unnamed = list[Finding](), list[Unnamed]()
    left_out = left_out_groups(found.refit.evidence)
    for cause in found.posterior.causes:
        if cause.coefficients is None or cause.nameless >= priors.PRESENT:
            unnamed.append(Unnamed(cause.form, cause.nameless, cause.joint, cause.note, cause.shares))
        else:
            named.append(_finding(found, cause, cause.coefficients, left_out))
    forms = {each.what: each for each in reversed(unnamed)}  # of one form the likeliest: causes are in that order
    return tuple(named), tuple(each for each in unnamed if forms[each.what] is each)


def not_separable(found: Inferred) -> dict[str, str]:
    """Return the names that the model's own parameters take wholly, with the measurement that separates each."""
    ways = {name: next(iter(found.pool.get(name, ())), None) for name in found.not_separable}
    return {name: way.effect.separate_by for name, way in ways.items() if way is not None}


def measure_next(findings: Sequence[Finding]) -> str:
    """Return the measurements that separate what is only possible."""
    return "; ".join(dict.fromkeys(each.separate_by for each in findings if each.confidence == "possible"))


def _finding(found: Inferred, cause: Cause, of: Coefficients, left_out: Sequence[IntArray]) -> Finding:
    effect, columns = of.candidate.effect, of.candidate.columns
    names, value, std = _sizes(found.refit, of)
    errors, share = _without(found.refit, effect, columns.where, left_out)
    name = cause.hypothesis.name
    return Finding(
        name, effect.kind, names, value, std, columns.unit or effect.unit, _where(cause, columns.where),
        cause.probability, _what_separates(found.refit, effect), shape=columns.shape, share=share,
        aliases=tuple(each for each in cause.shares if each != name), shares=cause.shares, joint=cause.joint,
        errors=errors, same_here=found.pool.same_as(of.candidate), times_expected=_times_expected(of),
    )  # fmt: skip


def _sizes(now: Refit, of: Coefficients) -> tuple[tuple[str, ...], FloatArray, FloatArray]:
    """Return names, values and 1 sigma of the coefficients that act likelier than not, last what is not linear.

    Between the points of a grid a time constant is known as well as the fit where the model stands with it says.
    """
    std = of.std
    seen: BoolArray = np.isfinite(std)
    bent = np.array([value for value, _ in of.nonlinear.values()])
    spread = np.array([log_std for _, log_std in of.nonlinear.values()])
    own = [i for i, each in enumerate(now.added) if _is_same(each, of.candidate)]
    if not of.candidate.effect.is_scatter:
        seen &= np.any(of.candidate.term.H[:, : len(std)], axis=0)
    acts = seen & (of.acts >= min(priors.PRESENT, float(np.max(of.acts[seen], initial=0.0))))
    if bent.size and len(own) == 1:
        k, fitted = len(std), np.sqrt(np.diag(now.linear.coefficients(own[0])[1]))
        std, spread = np.maximum(std, fitted[:k]), np.hypot(spread, fitted[k:])
        bent = np.array(list(now.added[own[0]].columns.nonlinear.values()))
    names = tuple(name for name, one in zip(of.names, acts.tolist(), strict=True) if one)
    return (*names, *of.nonlinear), np.append(of.value[acts], bent), np.append(std[acts], bent * spread)


def _times_expected(of: Coefficients) -> float:
    """Return the largest coefficient over the size that the catalogue states, both as they are shown."""
    effect, k = of.candidate.effect, len(of.value)
    expected = effect.plausible_of(of.candidate.columns)[:k]
    if effect.shown is not None:
        expected, _ = effect.shown(expected, np.zeros(k))
    return float(np.max(np.abs(of.value) / np.abs(expected[: len(of.value)]), initial=0.0))


def _is_same(one: Candidate, other: Candidate) -> bool:
    return one.effect.name == other.effect.name and one.columns.where == other.columns.where


def _where(cause: Cause, own: Mapping[str, object]) -> Mapping[str, object]:
    """Return where the coefficients act; of several positions that it may be, all, that one first."""
    places = [own, *(each for each, _ in cause.places)]
    several = list(dict.fromkeys(each["position"] for each in places if "position" in each))
    return dict(own) | ({"position": several} if len(several) > 1 else {})


def _what_separates(now: Refit, effect: Effect) -> str:
    """Return the measurement that would separate an effect from what looks like it; not one that is there."""
    is_certified = all(len(each.fixture.faces) == len(FACES) for each in now.fits.campaigns)
    return (is_certified and effect.separate_by_certified) or effect.separate_by


def _without(
    now: Refit, effect: Effect, where: Mapping[str, object], left_out: Sequence[IntArray]
) -> tuple[tuple[ResidualRms, ...], float | None]:
    """Return the errors held out of the rows on which an effect acts, without and with it, and the share it takes.

    All other effects are in the model both times. A scatter predicts nothing: it has none.
    """
    own = [i for i, each in enumerate(now.added) if (each.effect.name, each.columns.where) == (effect.name, where)]
    if effect.is_scatter or not own:
        return (), None
    evidence, terms = now.evidence, [each.term for each in now.added]
    after = fit_linear(evidence, terms)
    before = fit_linear(evidence, [each for i, each in enumerate(terms) if i not in own], factor=after.factor)
    acts = np.any(np.hstack([terms[i].H for i in own]) != 0, axis=1)
    errors = errors_of_fits(evidence, evidence, before, after, left_out, acts)
    squares = [np.square(predict_left_out(evidence, fit, left_out)[1]) for fit in (before, after)]
    rows = acts & evidence.is_data & np.isfinite(squares[0]) & np.isfinite(squares[1])
    whole = float(np.sum(squares[0][rows]))
    share = 1 - float(np.sum(squares[1][rows])) / whole if whole > 0 else None
    return errors, None if share is None else max(share, 0.0)
