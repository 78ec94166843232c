"""What to do next while a campaign runs: the first placing of the shortest way to what is wanted, or to stop.

The rule looks at sigmas alone: at what was done, how long, and how much the unit scatters. It never looks at
the values that were found, so that stopping does not choose among them and intervals keep their coverage.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.bench.dwell_length import SHORTEST_S
from procedures.planning.campaign_design import CampaignDesign, Placing
from procedures.planning.design_sigmas import DesignSigmas
from procedures.planning.dwell_lengths import LENGTH_STEP_S, LONGEST_S, is_met
from procedures.planning.least_time import FEWEST, MOST, SCANNED, least_time
from procedures.planning.order_search import OrderSearch
from procedures.planning.wanted_sigmas import WantedSigmas

MOST_TRIED = 4  # numbers of placings to come, from the fewest that may do


@dataclass(frozen=True, slots=True, eq=False)
class NextPlacing:
    """The placing that comes next, ``seconds`` that are left, 1 sigma (30,) of what was done.

    ``placing`` is None to stop, as all is met or, not reachable, as no attitude is left.
    ``way`` is the whole campaign that it belongs to, what was done first. ``is_reachable`` says whether what is
    wanted can be met; where not, the next placing is the best all the same.
    """

    placing: Placing | None
    seconds: float
    sigmas: FloatArray
    way: CampaignDesign
    is_reachable: bool = True


def next_placing(
    sigmas: DesignSigmas, wanted: WantedSigmas, done: Sequence[Placing], *, seed: int = 0, goes_on: bool = False
) -> NextPlacing:
    """Return what to do after the placings ``done``, which may be none; ``goes_on`` when all is met as well."""
    if not done:
        found = least_time(sigmas, wanted, turns=False, seed=seed)
        nothing = np.full(len(found.sigmas), np.inf)
        left = found.design.seconds(sigmas.steps.hands)
        return NextPlacing(found.design.placings[0], left, nothing, found.design, found.is_met)
    so_far = CampaignDesign(tuple(done))
    now = sigmas.of(so_far)
    if not goes_on and is_enough(sigmas, wanted, so_far):
        return NextPlacing(None, 0.0, now, so_far)
    if not OrderSearch(sigmas, wanted, SHORTEST_S, head=done).can_go_on():  # every attitude was taken
        return NextPlacing(None, 0.0, now, so_far, is_reachable=is_enough(sigmas, wanted, so_far))
    ways = [_way(sigmas, wanted, done, n, seed) for n in _numbers(len(so_far.positions))]
    hands = sigmas.steps.hands
    best = min(ways, key=lambda way: (not is_met(sigmas, wanted, way), way.seconds(hands)))
    left = best.seconds(hands) - so_far.seconds(hands)
    return NextPlacing(best.placings[len(done)], left, now, best, is_met(sigmas, wanted, best))


def is_enough(sigmas: DesignSigmas, wanted: WantedSigmas, so_far: CampaignDesign) -> bool:
    """Say whether what was done has all that is wanted, in placings enough to judge its residual by.

    A dwell under way with which it is enough pays no longer; what any other has to last was shared out among all
    placings to come.
    """
    return len(so_far.positions) >= FEWEST and is_met(sigmas, wanted, so_far)


def _numbers(done: int) -> range:
    fewest = max(FEWEST - done, 1)
    return range(fewest, max(min(fewest + MOST_TRIED, MOST + 1 - done), fewest + 1))


def _way(sigmas: DesignSigmas, wanted: WantedSigmas, done: Sequence[Placing], n: int, seed: int) -> CampaignDesign:
    """Return a campaign that goes on with n placings, as short as meet what is wanted, the longest if none do."""
    usual = float(np.median([at.seconds for at in done if at.turn is None]))
    found, _ = OrderSearch(sigmas, wanted, usual, head=done).best(n, seed, SCANNED)
    n = len(found.positions) - sum(at.turn is None for at in done)  # fewer where no more attitudes are left
    known = [at.seconds for at in done if at.turn is None]
    low, high = int(SHORTEST_S / LENGTH_STEP_S), int(LONGEST_S / LENGTH_STEP_S)
    while low < high:
        middle = (low + high) // 2
        met = is_met(sigmas, wanted, found.lasting([*known, *[middle * LENGTH_STEP_S] * n]))
        low, high = (low, middle) if met else (middle + 1, high)
    return found.lasting([*known, *[high * LENGTH_STEP_S] * n])
