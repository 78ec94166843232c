"""Whether another memory of what was before does as well as the one that was named.

A lag, a relaxation and a jump are the simplest of their kind. A sensor behind a housing lags twice; a hinge
keeps what the position before made of it, and nothing of it fades; a hysteresis with a play goes from one
branch to the other as soon as temperature turns. Each looks much like a simple one, whose coefficients are then
wrong. Each is put in the finding's place, and where it foretells the rows left out as well the finding is in
doubt. Two lags that no row tells from one are one lag: they must do better.
"""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from procedures.arrays import FloatArray
from procedures.diagnosis.candidates import Candidate, raising_does_not_fit
from procedures.diagnosis.effect_selection import MIN_DENSITY_GAIN
from procedures.diagnosis.held_out_errors import left_out_groups
from procedures.diagnosis.linear_model import Term, fit_linear, predict_left_out
from procedures.diagnosis.model_with_effects import LoopState
from procedures.diagnosis.outdone import DECISIVE
from procedures.effects.effect import Columns, per_axis
from procedures.effects.temperature_history import played, sensor_temperature
from procedures.errors import DoesNotFit
from procedures.frames import AXES

LONGER = 1.6  # times a lag's time constant, or that part of it, that two alike have together
PLAYS_K = (0.5, 1.0, 2.0, 4.0)  # half widths of a play
TRIES = 12  # time constants of two lags that are tried
INSTEAD_OF_PLAY = ("temperature_rate", "temperature_lag", "temperature_hysteresis")


def remembers_otherwise(state: LoopState, finding: Candidate) -> bool:
    """Say whether a lag of a lag, the position before or a play is what a lag, relaxation or jump is taken for."""
    seen, (triad, _, name) = state.now.evidence.excitation, finding.effect.name.partition(".")
    beside = state.beside(finding)
    if name == "relaxation":
        return _gain(state, finding, np.nan_to_num(seen.f_before), beside) > -MIN_DENSITY_GAIN
    if name == "jump" and np.isfinite(seen.temperature).all():
        instead = [f"{triad}.{each}" for each in INSTEAD_OF_PLAY]
        kept = [each for each in state.adopted if each.candidate.effect.name not in instead]
        free = [each.term for each in kept if not (each.candidate is finding or each.candidate.is_of_model)]
        backlashes = (seen.temperature - played(seen, width) for width in PLAYS_K)
        least = -MIN_DENSITY_GAIN - float(np.log(max(len(state.pool.get(finding.effect.name, ())), 1)))
        return any(_gain(state, finding, values, free) > least for values in backlashes)
    return name == "temperature_lag" and _gain_of_two_lags(state, finding) > DECISIVE


def _gain_of_two_lags(state: LoopState, finding: Candidate) -> float:
    """Return the gain of two lags of one time constant, that which foretells best."""
    beside, seen = state.beside(finding), state.now.evidence.excitation

    def loss(log_tau: float) -> float:
        tau = float(np.exp(log_tau))
        return -_gain(state, finding, sensor_temperature(seen, tau, lags=2), beside)

    middle, about = np.log(finding.columns.tau_s / 2), np.log(LONGER)
    found = minimize_scalar(
        loss, bounds=(middle - about, middle + about), method="bounded", options={"maxiter": TRIES}
    )
    return -float(found.fun)


def _gain(state: LoopState, finding: Candidate, values: FloatArray, beside: Sequence[Term]) -> float:
    """Return what rows left out gain by values (n,) or (n, 3), beside terms, in a finding's place [ln density]."""
    evidence, left_out = state.now.evidence, left_out_groups(state.now.evidence)
    others = state.beside(finding)
    if finding.columns.tau_s:  # the other's time constant is chosen, too, and not in its columns
        kept = slice(len(finding.columns.coefficients) - 1)
        finding = replace(finding, term=Term(finding.term.H[:, kept], finding.term.plausible[kept]))
    fit = finding.fit(evidence, others)
    H = evidence.column(_columns(finding, values))
    used = np.isfinite(H).all(axis=0) & H.any(axis=0)
    with suppress(DoesNotFit), raising_does_not_fit():
        there = fit_linear(
            evidence, [*beside, Term(H[:, used], np.full(int(used.sum()), np.inf))], factor=fit.factor
        )
        gain = predict_left_out(evidence, there, left_out)[0] - predict_left_out(evidence, fit, left_out)[0]
        return float(gain)
    return -np.inf


def _columns(finding: Candidate, values: FloatArray) -> Columns:
    if finding.effect.name.startswith("accelerometer"):
        return Columns(tuple(AXES), accel=per_axis(values))
    return Columns(tuple(AXES), gyro=per_axis(values))
