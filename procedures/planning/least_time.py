"""The campaign that has all that is wanted in the least time, or the most of it in a time that is given.

For every number of placings the best order is searched at the length that the dwells then have; a few exchanges
later orders and lengths agree. With turns and without are tried alike, where turns may be done at all.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.bench.dwell_length import SHORTEST_S
from procedures.planning.campaign_design import TURN_PLACINGS, CampaignDesign, Placing
from procedures.planning.design_sigmas import DesignSigmas
from procedures.planning.dwell_lengths import LENGTH_STEP_S, equal_lengths, shared_out, shortened
from procedures.planning.order_search import OrderSearch
from procedures.planning.wanted_sigmas import WantedSigmas
from procedures.units import S_PER_MIN

FEWEST, MOST = 8, 18  # placings tried: fewer leave next to nothing for the residual to judge by
FIRST_TRIED_S = 50.0  # s, of a dwell at which an order is searched first
ROUNDS = 2  # of order and lengths in turn
SCANNED = 3  # beginnings of a search for every number of placings; the best number is searched with more
PATIENCE = 3  # numbers of placings without a gain after which more of them are not tried
LONGEST_MIN = 60.0  # min: what is not met within is said to be out of reach


@dataclass(frozen=True, slots=True, eq=False)
class PlannedCampaign:
    """A design, its sigmas (30,), as `NAMES`, and whether they are what was wanted."""

    design: CampaignDesign
    sigmas: FloatArray
    is_met: bool


def least_time(
    sigmas: DesignSigmas, wanted: WantedSigmas, *, turns: bool = True, seed: int = 0
) -> PlannedCampaign:
    """Return the shortest campaign that meets what is wanted; the best of `LONGEST_MIN` where none does."""
    best: CampaignDesign | None = None
    hands = sigmas.steps.hands
    for tail in _tails(turns):
        idle = 0
        for n in range(FEWEST, MOST + 1):
            if best is not None and _least_seconds(sigmas, n, tail) >= best.seconds(hands):
                break
            found = _shortest(sigmas, wanted, n, tail, seed)
            is_better = found is not None and (best is None or found.seconds(hands) < best.seconds(hands))
            best, idle = (found, 0) if is_better else (best, idle + (best is not None))
            if idle == PATIENCE:
                break
    if best is None or best.minutes(hands) > LONGEST_MIN:
        return most_in_time(sigmas, wanted, LONGEST_MIN, turns=turns, seed=seed)
    return planned(sigmas, wanted, _refined(sigmas, wanted, best, seed))


def _refined(sigmas: DesignSigmas, wanted: WantedSigmas, best: CampaignDesign, seed: int) -> CampaignDesign:
    """Return the shortest campaign of as many placings that more beginnings of the search find."""
    n, hands = len(best.positions), sigmas.steps.hands
    tail, seconds = best.placings[n:], float(np.mean([at.seconds for at in best.placings[:n]]))
    other, _ = OrderSearch(sigmas, wanted, seconds, tail=tail).best(n, seed + 1)
    equal = equal_lengths(sigmas, wanted, other)
    return (
        best
        if equal is None
        else min(best, shortened(sigmas, wanted, equal), key=lambda each: each.seconds(hands))
    )


def most_in_time(
    sigmas: DesignSigmas, wanted: WantedSigmas, minutes: float, *, turns: bool = True, seed: int = 0
) -> PlannedCampaign:
    """Return the campaign of ``minutes`` whose sigmas are nearest to what is wanted.

    Raises
    ------
    ValueError
        If ``minutes`` are too few for any campaign; the message says what is expected.
    """
    scanned = [
        (OrderSearch(sigmas, wanted, seconds, tail=tail).best(n, seed, SCANNED)[1], n, seconds, tail)
        for tail in _tails(turns)
        for n, seconds in _fitting(sigmas, minutes, tail)
    ]
    if not scanned:
        fewest = _least_seconds(sigmas, FEWEST, ()) / S_PER_MIN
        raise ValueError(f"{fewest:.1f} min or more, for {FEWEST} placements")
    _, n, seconds, tail = min(scanned, key=lambda each: each[0])
    best, _ = OrderSearch(sigmas, wanted, seconds, tail=tail).best(n, seed)
    return planned(sigmas, wanted, shared_out(sigmas, wanted, best))


def _fitting(sigmas: DesignSigmas, minutes: float, tail: Sequence[Placing]) -> Iterator[tuple[int, float]]:
    """Give numbers of placings and the length [s] that their dwells have in a time."""
    for n in range(FEWEST, MOST + 1):
        left = minutes * S_PER_MIN - _least_seconds(sigmas, n, tail)
        if left >= 0:
            yield n, SHORTEST_S + left / n // LENGTH_STEP_S * LENGTH_STEP_S


def planned(sigmas: DesignSigmas, wanted: WantedSigmas, design: CampaignDesign) -> PlannedCampaign:
    """Return a design with its sigmas."""
    found = sigmas.of(design)
    return PlannedCampaign(design, found, bool(wanted.worst(found) <= 1))


def _tails(turns: bool) -> Iterator[Sequence[Placing]]:
    yield ()
    if turns:
        yield TURN_PLACINGS


def _least_seconds(sigmas: DesignSigmas, n: int, tail: Sequence[Placing]) -> float:
    hands = sigmas.steps.hands
    return n * (hands.placing + SHORTEST_S) + len(tail) * hands.turn


def _shortest(
    sigmas: DesignSigmas, wanted: WantedSigmas, n: int, tail: Sequence[Placing], seed: int
) -> CampaignDesign | None:
    """Return the shortest campaign of n dwells, None if it cannot meet what is wanted."""
    found, _ = OrderSearch(sigmas, wanted, FIRST_TRIED_S, tail=tail).best(n, seed, SCANNED)
    best = equal_lengths(sigmas, wanted, found)
    if best is None:
        return None
    for _ in range(ROUNDS):
        seconds = best.placings[0].seconds
        found, _ = OrderSearch(sigmas, wanted, seconds, tail=tail).improved(best)
        shorter = equal_lengths(sigmas, wanted, found)
        if shorter is None or shorter.placings[0].seconds >= seconds:
            break
        best = shorter
    return shortened(sigmas, wanted, best)
