"""The solution with what bench and procedure did, and nothing of the instrument.

A calibration claims no effect of the instrument that is in doubt. What was found of the bench stays in it all the
same: turns that closed worse than stated leave the scale factor as open as they are, whatever else is in doubt.
"""

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from procedures.diagnosis.declared_effects import declared_effects
from procedures.diagnosis.linear_model import fit_linear
from procedures.diagnosis.model_with_effects import LoopState
from procedures.diagnosis.result import BenchAlone, Finding
from procedures.diagnosis.unexplained_residual import within_dwells
from procedures.errors import DoesNotFit


def bench_alone(state: LoopState, findings: Sequence[Finding], *, is_left: bool) -> BenchAlone | None:
    """Solve with the findings of bench and procedure alone; None where none of the instrument is in doubt.

    None as well where nothing of the bench was added to the model: then it is the solution without any effect.
    ``is_left`` says that the global test leaves more than noise.
    """
    kept = [each for each in state.adopted if each.candidate.effect.kind != "instrument"]
    in_doubt = any(each.kind == "instrument" and each.confidence == "ambiguous" for each in findings)
    if not in_doubt or all(each.candidate.is_of_model for each in kept):
        return None
    with suppress(DoesNotFit):
        state = state.solved_with(kept)
        evidence = state.now.evidence
        fit = fit_linear(evidence, state.beside(), factor=np.ones(len(evidence.residual)))
        left = within_dwells(evidence, fit) if is_left else None
        return BenchAlone(state.now.fits, state.subject.report(state.now), left, declared_effects(state.now))
    return None
