"""Which effects explain enough: those that do not are dropped, and a finding that leaves structure is in doubt.

A cause leaves noise. What leaves more than half of what it was brought in for, or next to all where rows are left
out, is none; what leaves a part of it may be a likeness of the cause.
"""

from operator import itemgetter

import numpy as np

from procedures.diagnosis.candidates import Candidate
from procedures.diagnosis.effect_selection import AdoptedEffect
from procedures.diagnosis.left_directions import excess_along, worst_direction
from procedures.diagnosis.linear_model import LinearFit, fit_linear
from procedures.diagnosis.model_with_effects import LoopState
from procedures.diagnosis.outdone import share_foretold
from procedures.diagnosis.result import UNEXPLAINED_LOG_P, Because, Finding
from procedures.diagnosis.unexplained_residual import excess_squares, global_log_p
from procedures.errors import DoesNotFit
from procedures.frames import TRIADS

# Of what is left: below it an effect must have explained half of what it was brought in for.
DROP_BELOW_LOG_P = np.log(1e-3)
MIN_EXPLAINED_SHARE = 0.5
MIN_HELD_OUT_SHARE = 0.1  # of the excess where rows are left out, below which an effect is none
SURE_SHARE = 0.95  # of it: an effect that explains less looks like the cause, or like a part of it


def without_effect(state: LoopState, gone: AdoptedEffect) -> LoopState:
    """Return where the loop stands without an effect; those that do not fit without it go with it."""
    left = [each for each in state.adopted if each is not gone]
    while left:
        try:
            return state.solved_with(left)
        except DoesNotFit:
            left.pop()
    return state.solved_with(())


def left_log_p(state: LoopState) -> float:
    """Return ln p of what the model with all its effects leaves, as a whole and along anything it may go with."""
    fit = unwidened_fit(state)
    along = worst_direction(state.now.evidence, fit)
    both = (global_log_p(state.now.evidence, fit), 0.0 if along is None else along.log_p)
    return min(min(both) + float(np.log(2)), 0.0)


def unwidened_fit(state: LoopState, but: Candidate | None = None) -> LinearFit:
    """Return the fit with all effects, ``but`` for one, by counting noise: no row's sigma is widened."""
    return fit_linear(state.now.evidence, state.beside(but), factor=np.ones(len(state.now.evidence.residual)))


def drop_unexplaining(state: LoopState) -> LoopState:
    """Drop effects that leave more than half of what they were brought in to explain."""
    while left_log_p(state) < DROP_BELOW_LOG_P:
        wanting = [
            (share, each)
            for each in state.adopted
            if not each.candidate.is_of_model
            and (share := _explained(state, each.candidate)) < MIN_EXPLAINED_SHARE
        ]
        if not wanting:
            break
        state = without_effect(state, min(wanting, key=lambda each: each[0])[1])
    return state


def drop_unforetelling(state: LoopState) -> LoopState:
    """Drop effects of the instrument that explain next to nothing of what is left out.

    What may hang on one step, as a seating or a jump does, is seen there alone: nothing foretells it.
    """
    while True:
        own = [each for each in state.adopted if _may_foretell(each.candidate)]
        share, least = min(
            ((share_foretold(state, each), each) for each in own), key=itemgetter(0), default=(1, None)
        )
        if least is None or share >= MIN_HELD_OUT_SHARE:
            return state
        state = without_effect(state, least)


def _may_foretell(candidate: Candidate) -> bool:
    effect = candidate.effect
    return effect.kind == "instrument" and not (candidate.is_of_model or effect.may_hang_on_a_step)


def _explained(state: LoopState, candidate: Candidate) -> float:
    """Return how much of what noise does not explain a candidate does; of an instrument's, in its own triad."""
    stated, triad = candidate.effect.is_scatter, candidate.effect.name.partition(".")[0]
    own = triad if candidate.effect.kind == "instrument" and triad in TRIADS else None
    without = excess_squares(state.now.evidence, unwidened_fit(state, candidate), own, with_stated=stated)
    with_it = excess_squares(state.now.evidence, unwidened_fit(state), own, with_stated=stated)
    return 1 - with_it / without if without > 0 else 0.0


def in_doubt_where_left(state: LoopState, adopted: AdoptedEffect, finding: Finding) -> Finding:
    """Return a finding in doubt where it leaves structure: a cause leaves noise, a likeness does not."""
    if adopted.candidate.is_of_model:
        return finding
    share = min(_explained(state, adopted.candidate), _explained_along(state, adopted.candidate))
    return finding if share >= SURE_SHARE else finding.doubted(Because.PATTERN, value=share)


def _explained_along(state: LoopState, candidate: Candidate) -> float:
    """Return how much an instrument's effect explains of what there is where its triad's residual shows most."""
    evidence, triad = state.now.evidence, candidate.effect.name.split(".")[0]
    fit = unwidened_fit(state)
    along = worst_direction(evidence, fit, triad) if candidate.effect.kind == "instrument" else None
    if along is None or along.log_p >= UNEXPLAINED_LOG_P:
        return 1.0
    without = excess_along(unwidened_fit(state, candidate), along.H)
    return 1 - excess_along(fit, along.H) / without if without > 0 else 0.0
