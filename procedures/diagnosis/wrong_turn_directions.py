"""``placement.label`` of turns: recorded in the opposite direction, as the Earth's rate in the dwells shows.

They are turned round before anything else is asked: by them the gyroscopes would count backwards, and every dwell
would seem to stand in its face's other position.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from procedures.bench.sign_errors import earth_signs, reversed_axes
from procedures.campaign.campaign import Campaign, TurnRecord
from procedures.diagnosis.dwell_headings import scale_factors_from_turns
from procedures.diagnosis.result import CERTAIN, Finding
from procedures.diagnosis.wrong_positions import EFFECT, triad_rates
from procedures.frames import AXES

OPPOSITE = {"+": "-", "-": "+"}


def with_true_directions(campaigns: Sequence[Campaign]) -> tuple[tuple[Campaign, ...], tuple[Finding, ...]]:
    """Return the campaigns with the turns that are wrongly labelled for certain turned round, and the findings."""
    corrected, findings = list[Campaign](), list[Finding]()
    for campaign in campaigns:
        axes = _wrong_axes(campaign)
        wrong = [turn for turn in campaign.turns if turn.axis in axes]
        turns = tuple(_other_way(turn) if turn in wrong else turn for turn in campaign.turns)
        corrected.append(replace(campaign, turns=turns) if wrong else campaign)
        findings += [_finding([turn.name for turn in wrong])] if wrong else []
    return tuple(corrected), tuple(findings)


def _wrong_axes(campaign: Campaign) -> str:
    K = scale_factors_from_turns(campaign)
    if K is None or not np.all(np.linalg.norm(K, axis=1) > 0):
        return ""
    rate, std = triad_rates(campaign.dwells, "gyroscope")
    seen = np.flatnonzero(np.all(np.isfinite(rate) & np.isfinite(std), axis=1))
    dwells = [(0, campaign.dwells[i].position) for i in seen.tolist()]
    signs = earth_signs([campaign], dwells, rate[seen], std[seen], K)
    marked = reversed_axes(K, signs, campaign.fixture.C_sb)
    return "".join(axis for axis, it_is in zip(AXES, marked, strict=True) if it_is)


def _other_way(turn: TurnRecord) -> TurnRecord:
    return replace(turn, direction=OPPOSITE[turn.direction])


def _finding(names: Sequence[str]) -> Finding:
    return Finding(
        EFFECT, "procedure", ("direction",), np.array([-1.0]), np.array([0.0]), "direction", {"file": list(names)},
        CERTAIN, "the turns again, in the direction they are asked for",
    )  # fmt: skip
