"""The thresholds of the loop are those that `docs/closed-loop.md` gives reasons and figures for."""

import math

import numpy as np
import pytest

from procedures.diagnosis import (
    diagnose,
    effect_selection,
    enough_explained,
    equivalent_effects,
    excitation,
    left_pattern,
    linear_model,
)
from tests.paths import ROOT

PAGE = " ".join((ROOT / "docs/closed-loop.md").read_text(encoding="utf-8").split())

SAID = [
    ("have a plausible size: at most five times the range", effect_selection.MAX_TIMES_PLAUSIBLE, 5.0),
    ("The winner needs an adjusted p below 0.01", effect_selection.MAX_LOG_P, math.log(0.01)),
    ("that can explain (p < 0.05 of the fit", linear_model.WIDENED_LOG_P, math.log(0.05)),
    ("blind to what only they show", linear_model.NORMS_WIDENED_LOG_P, math.log(0.001)),
    ("unless p < 0.001, the means of dwells must scatter", linear_model.NORMS_WIDENED_LOG_P, math.log(0.001)),
    ("above -1.645, and an expected 1.645 sigmas", linear_model.MIN_EXPECTED_SIGMAS, 1.645),
    ("that stood above three sigma below it", equivalent_effects.STANDS_SIGMAS, 3.0),
    ("and takes at least half of it", equivalent_effects.MAX_LEFT_SHARE, 0.5),
    ("Below 0.01 the verdict is **partly** or **unexplained**", diagnose.UNEXPLAINED_LOG_P, math.log(0.01)),
    ("Where it is below 0.001, an effect stands only", enough_explained.DROP_BELOW_LOG_P, math.log(0.001)),
    ("only if it explained half of what it was brought in", enough_explained.MIN_EXPLAINED_SHARE, 0.5),
    ("is in doubt unless it explained 95 %", enough_explained.SURE_SHARE, 0.95),
    ("(96 of a dwell, every 0.1 s of a turn)", excitation.DWELL_NODES, 96),
    ("(96 of a dwell, every 0.1 s of a turn)", excitation.TURN_NODE_S, 0.1),
    ("goes with a parabola of temperature or time", left_pattern.DEGREE, 2),
]


@pytest.mark.parametrize(("text", "value", "stated"), SAID)
def test_the_page_states_the_threshold(text: str, value: float, stated: float) -> None:
    assert text in PAGE
    assert np.isclose(value, stated, rtol=1e-12)
