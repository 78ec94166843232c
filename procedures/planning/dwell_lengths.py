"""How long each dwell of an order must be: the same for all, then each by itself."""

import numpy as np

from procedures.bench.dwell_length import SHORTEST_S
from procedures.planning.campaign_design import CampaignDesign
from procedures.planning.design_sigmas import DesignSigmas
from procedures.planning.wanted_sigmas import WantedSigmas

LONGEST_S = 600.0  # s: beyond that a bias's wander is all that is left
LENGTH_STEP_S = 5.0
STEPS_TRIED_S = (40.0, 20.0, 10.0, LENGTH_STEP_S)


def equal_lengths(sigmas: DesignSigmas, wanted: WantedSigmas, design: CampaignDesign) -> CampaignDesign | None:
    """Return the design with the shortest equal dwells that meet what is wanted, None if `LONGEST_S` do not."""
    n = len(design.positions)
    low, high = int(SHORTEST_S / LENGTH_STEP_S), int(LONGEST_S / LENGTH_STEP_S)
    if not is_met(sigmas, wanted, design.lasting([LONGEST_S] * n)):
        return None
    while low < high:
        middle = (low + high) // 2
        met = is_met(sigmas, wanted, design.lasting([middle * LENGTH_STEP_S] * n))
        low, high = (low, middle) if met else (middle + 1, high)
    return design.lasting([high * LENGTH_STEP_S] * n)


def is_met(sigmas: DesignSigmas, wanted: WantedSigmas, design: CampaignDesign) -> bool:
    """Say whether a design has all that is wanted."""
    return bool(wanted.worst(sigmas.of(design)) <= 1)


def shortened(sigmas: DesignSigmas, wanted: WantedSigmas, design: CampaignDesign) -> CampaignDesign:
    """Shorten dwells one by one, each time that which costs least, while all that is wanted is met."""
    lengths = _lengths(design)
    for step in STEPS_TRIED_S:
        while True:
            tried = [_changed(lengths, {i: -step}) for i in range(len(lengths))]
            found = [
                (each, wanted.score(sigmas.of(design.lasting(each)))) for each in tried if min(each) >= SHORTEST_S
            ]
            met = [(score, each) for each, score in found if is_met(sigmas, wanted, design.lasting(each))]
            if not met:
                break
            lengths = min(met)[1]
    return design.lasting(lengths)


def shared_out(sigmas: DesignSigmas, wanted: WantedSigmas, design: CampaignDesign) -> CampaignDesign:
    """Take time from one dwell and give it to another while that is a gain; the whole stays as long as it is."""
    best = float(wanted.score(sigmas.of(design)))
    for step in STEPS_TRIED_S[1:]:
        gained = True
        while gained:
            lengths, gained = _lengths(design), False
            longer = [design.lasting(_changed(lengths, {i: step})) for i in range(len(lengths))]
            to = int(np.argmin([wanted.score(sigmas.of(each)) for each in longer]))
            for i, seconds in enumerate(lengths):
                if i == to or seconds - step < SHORTEST_S:
                    continue
                tried = design.lasting(_changed(lengths, {i: -step, to: step}))
                score = float(wanted.score(sigmas.of(tried)))
                if score < best:
                    best, design, gained = score, tried, True
                    break
    return design


def _lengths(design: CampaignDesign) -> list[float]:
    return [at.seconds for at in design.placings if at.turn is None]


def _changed(lengths: list[float], by: dict[int, float]) -> list[float]:
    return [seconds + by.get(i, 0.0) for i, seconds in enumerate(lengths)]
