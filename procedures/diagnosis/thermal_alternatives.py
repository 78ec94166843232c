"""What could stand in the place of what temperature and time were found to do: a lag, another smooth drift.

A lag that the model lacks comes out as a drift with a coefficient of temperature, each of them far from nought
and both wrong. So all that was found of one triad's bias by temperature and time is held together against
others: against a sensor that follows, with and without a coefficient of the temperature recorded, against a
hysteresis with a play beside such a coefficient, and against a cubic in time. Where one of them foretells what
is left out as well, a name that it does not bear out is not sure. What settles since power-on is nearly a drift or
what a settling temperature does, one number of which is fitted: it must foretell better than these.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.diagnosis.candidates import Candidate, raising_does_not_fit
from procedures.diagnosis.effect_selection import MIN_DENSITY_GAIN, AdoptedEffect
from procedures.diagnosis.held_out_errors import left_out_groups
from procedures.diagnosis.linear_model import LinearFit, Term, fit_linear, predict_left_out
from procedures.diagnosis.model_with_effects import LoopState
from procedures.diagnosis.other_memories import PLAYS_K
from procedures.diagnosis.residual_rows import Evidence
from procedures.diagnosis.result import Because, Finding
from procedures.effects.effect import Columns, per_axis
from procedures.effects.temperature_history import played
from procedures.errors import DoesNotFit

COEFFICIENT, RATE, DRIFT, LAG, HYSTERESIS, SETTLING = NAMES = (
    "bias_temperature", "temperature_rate", "bias_drift", "temperature_lag", "temperature_hysteresis",
    "bias_settling",
)  # fmt: skip
ONE_REFINED = ({COEFFICIENT, LAG}, {COEFFICIENT, SETTLING}, {DRIFT, SETTLING})
PLAINER_OR_REFINED = {LAG: (COEFFICIENT,), SETTLING: (COEFFICIENT, DRIFT), DRIFT: (SETTLING,)}
SMOOTH, PLAY = "in time", "with a play"
SMOOTH_DEGREE = 3  # of a drift in time
BORNE_OUT_SIGMAS = 3.0  # within which another model must have a coefficient to bear it out


@dataclass(frozen=True, slots=True, eq=False)
class _Model:
    """What might be instead: terms by name, in how many ways it was tried, and what it must gain to be a rival.

    ``names`` are those it goes by, where they are not those of the terms.
    """

    terms: dict[str, Term]
    tried: int = 1
    least_gain: float = -MIN_DENSITY_GAIN
    names: tuple[str, ...] | None = None


def thermal_name(candidate: Candidate) -> str:
    """Return which of `NAMES` an effect is, '' if none."""
    name = candidate.effect.name.partition(".")[2]
    return name if name in NAMES else ""


def in_doubt_together(adopted: Sequence[AdoptedEffect], findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings, in doubt what acts by temperature beside one of its triad that is in doubt."""
    triads = [_triad(each.candidate) if thermal_name(each.candidate) else "" for each in adopted]
    doubted = {one for one, each in zip(triads, findings, strict=True) if each.confidence == "ambiguous"} - {""}
    return tuple(
        each.doubted(Because.TOGETHER, one) if one in doubted and each.confidence != "ambiguous" else each
        for one, each in zip(triads, findings, strict=True)
    )


def is_refined(finding: Candidate, other: Candidate) -> bool:
    """Say whether one of two is the other with a time constant: judged here, not by columns that are alike."""
    names = {thermal_name(finding), thermal_name(other)}
    return names in ONE_REFINED and _triad(finding) == _triad(other)


def plainer_or_refined(state: LoopState, finding: Candidate) -> list[Candidate]:
    """Return what a lag or a settling may be no more than, what a drift may be nearly; none of what is adopted."""
    triad, adopted = _triad(finding), {each.candidate.effect.name for each in state.adopted}
    names = [f"{triad}.{name}" for name in PLAINER_OR_REFINED.get(thermal_name(finding), ())]
    return [way for name in names if name not in adopted for way in state.pool.get(name, ())]


def other_explanations(state: LoopState, finding: Candidate) -> tuple[str, ...]:
    """Return what could be in the place of all that temperature and time were found to do to a triad."""
    if not (own_name := thermal_name(finding)):
        return ()
    triad, evidence = _triad(finding), state.now.evidence
    if own_name in {DRIFT, SETTLING} and not np.isfinite(evidence.excitation.temperature).any():
        return (f"{triad}.{COEFFICIENT}",)  # of a temperature that nobody recorded
    own = {
        thermal_name(each.candidate): each.candidate
        for each in state.adopted
        if thermal_name(each.candidate) and _triad(each.candidate) == triad
    }
    beside = [term for term in state.beside() if all(term is not each.term for each in own.values())]
    fit = fit_linear(evidence, [*beside, *(each.term for each in own.values())])
    as_found, coefficients = _density(evidence, fit), fit.coefficients(len(beside) + list(own).index(own_name))
    found = dict[str, None]()
    for model in _models(state, triad, own):
        with suppress(DoesNotFit), raising_does_not_fit():
            there = fit_linear(evidence, [*beside, *model.terms.values()], factor=fit.factor)
            gain = _density(evidence, there) - as_found - float(np.log(model.tried))
            if gain > model.least_gain and not _bears_out(coefficients, there, len(beside), own_name, model):
                names = model.terms if model.names is None else model.names
                found |= dict.fromkeys(f"{triad}.{name}" for name in names if name != own_name)
    return tuple(found)


def _triad(candidate: Candidate) -> str:
    return candidate.effect.name.partition(".")[0]


def _density(evidence: Evidence, fit: LinearFit) -> float:
    return predict_left_out(evidence, fit, left_out_groups(evidence))[0]


def _models(state: LoopState, triad: str, own: dict[str, Candidate]) -> Iterator[_Model]:
    """Yield what could be instead of what was found, but for the same again."""
    ways = {name: list(state.pool.get(f"{triad}.{name}", ())) for name in NAMES}
    plain = [own[COEFFICIENT]] if COEFFICIENT in own else ways[COEFFICIENT][:1]
    for lag in [] if LAG in own else ways[LAG]:
        yield _Model({LAG: lag.term}, len(ways[LAG]))
        if plain:
            yield _Model({COEFFICIENT: plain[0].term, LAG: lag.term}, len(ways[LAG]))
    if {LAG, HYSTERESIS} & own.keys() and plain:
        for name in (RATE, DRIFT, HYSTERESIS):
            if name not in own and ways[name]:
                yield _Model({COEFFICIENT: plain[0].term, name: ways[name][0].term})
    for lag in ways[LAG] if {COEFFICIENT, HYSTERESIS} <= own.keys() and LAG not in own else []:
        # whichever lag the data do not exclude: what it does like a rate, a play takes for its own
        yield _Model({LAG: lag.term, HYSTERESIS: own[HYSTERESIS].term}, names=(LAG,))
    for play in [] if HYSTERESIS in own else ways[HYSTERESIS]:
        yield _Model({HYSTERESIS: play.term}, len(ways[HYSTERESIS]))
    if plain and {RATE, LAG} & own.keys() and HYSTERESIS not in own:
        for width in PLAYS_K:
            of_play = _free(state.now.evidence, triad, per_axis(played(state.now.evidence.excitation, width)))
            yield _Model({COEFFICIENT: plain[0].term, PLAY: of_play}, len(PLAYS_K), names=(HYSTERESIS,))
    if SETTLING in own:
        yield from (_Model({each: ways[each][0].term}) for each in (COEFFICIENT, DRIFT) if ways[each])
    smooth = {SMOOTH: _smooth(state.now.evidence, triad)}
    if set(own) == {DRIFT}:  # a line is a cubic too: it is none where the cubic is better
        yield _Model(smooth, least_gain=MIN_DENSITY_GAIN, names=(LAG if ways[LAG] else COEFFICIENT,))
        for way in ways[SETTLING]:
            yield _Model({SETTLING: way.term}, len(ways[SETTLING]), MIN_DENSITY_GAIN)
    else:
        yield _Model(smooth, names=(DRIFT,))


def _smooth(evidence: Evidence, triad: str) -> Term:
    """Return polynomials of time in every history, for each sensor, of any size."""
    seen, columns = evidence.excitation, list[FloatArray]()
    history = seen.histories[seen.step]
    for number in np.unique(history):
        here = history == number
        t = seen.t - seen.t[here].min()
        x = 2 * t / max(float(t[here].max()), 1.0) - 1
        for degree in range(1, SMOOTH_DEGREE + 1):
            columns.append(per_axis(np.where(here, x**degree, 0.0)))
    return _free(evidence, triad, np.concatenate(columns, axis=2))


def _free(evidence: Evidence, triad: str, values: FloatArray) -> Term:
    """Return values (n, 3, k) that are added to a triad's output as a term, of any size."""
    names = tuple(str(i) for i in range(values.shape[2]))
    found = Columns(names, accel=values) if triad == "accelerometer" else Columns(names, gyro=values)
    H = evidence.column(found)
    used = H.any(axis=0)
    return Term(H[:, used], np.full(int(used.sum()), np.inf))


def _bears_out(
    found: tuple[FloatArray, FloatArray], there: LinearFit, beside: int, own_name: str, model: _Model
) -> bool:
    """Say whether another model has a finding's coefficients (k,) with their covariance."""
    names = list(model.terms)
    is_lagged = own_name == COEFFICIENT and names[0] == LAG
    name = own_name if own_name in names else LAG if is_lagged else ""
    if not name:
        return False
    c, C = found
    other, wider = (part[..., : len(c)] for part in there.coefficients(beside + names.index(name)))
    if len(other) < len(c):
        return False  # a polynomial, of which the other has only the line
    std, wide = np.sqrt(np.diag(C)), np.sqrt(np.diag(wider))
    same = (np.abs(other - c) < BORNE_OUT_SIGMAS * wide) & (np.abs(other) > BORNE_OUT_SIGMAS * wide)
    return bool(np.all(same[np.abs(c) > BORNE_OUT_SIGMAS * std]))
