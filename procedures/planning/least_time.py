"""The shortest campaign that reaches wanted uncertainties, the best in a given time, and the best next placement.

For every number of placements the best order is searched at the length that the dwells then have; a few exchanges
later orders and lengths agree. With turns and without are tried alike, where turns may be done at all.

What to do next while a campaign runs: the first placement of the shortest way to what is wanted, or to stop.
The rule looks at sigmas alone: at what was done, how long, and how much the unit scatters. It never looks at
the values that were found, so that stopping does not choose among them and intervals keep their coverage.
"""

from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from procedures.arrays import FloatArray
from procedures.bench.dwell_length import SHORTEST_S
from procedures.planning.campaign_design import ROTATION_PLACEMENTS, CampaignDesign, Placement
from procedures.planning.design_sigmas import DesignSigmas, WantedSigmas
from procedures.planning.order_search import OrderSearch
from procedures.units import S_PER_MIN

LONGEST_S = 600.0  # s: beyond that a bias instability is all that is left
LENGTH_STEP_S = 5.0
STEPS_TRIED_S = (40.0, 20.0, 10.0, LENGTH_STEP_S)


def equal_lengths(sigmas: DesignSigmas, wanted: WantedSigmas, design: CampaignDesign) -> CampaignDesign | None:
    """Return the design with the shortest equal dwells that meet what is wanted, None if `LONGEST_S` do not."""
    n = len(design.positions)
    if not is_met(sigmas, wanted, design.lasting([LONGEST_S] * n)):
        return None
    return _shortest_equal(sigmas, wanted, lambda seconds: design.lasting([seconds] * n))


def _shortest_equal(
    sigmas: DesignSigmas, wanted: WantedSigmas, lasting: Callable[[float], CampaignDesign]
) -> CampaignDesign:
    """Return the design ``lasting`` so many seconds a dwell as meet what is wanted, `LONGEST_S` if none do."""
    steps = range(int(SHORTEST_S / LENGTH_STEP_S), int(LONGEST_S / LENGTH_STEP_S))
    least = bisect_left(steps, True, key=lambda k: is_met(sigmas, wanted, lasting(k * LENGTH_STEP_S)))
    return lasting((steps.start + least) * LENGTH_STEP_S)


def is_met(sigmas: DesignSigmas, wanted: WantedSigmas, design: CampaignDesign) -> bool:
    """Say whether a design has all that is wanted."""
    return bool(wanted.worst(sigmas.of(design)) <= 1)


def shortened(sigmas: DesignSigmas, wanted: WantedSigmas, design: CampaignDesign) -> CampaignDesign:
    """Shorten dwells one by one, each time that which costs least, while all that is wanted is met."""
    lengths = _lengths(design)
    for step in STEPS_TRIED_S:
        while True:
            tried = [_changed(lengths, {i: -step}) for i in range(len(lengths))]
            found = [(sigmas.of(design.lasting(each)), each) for each in tried if min(each) >= SHORTEST_S]
            met = [(wanted.score(each), its) for each, its in found if wanted.worst(each) <= 1]
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
    return [at.seconds for at in design.placements if at.turn is None]


def _changed(lengths: list[float], by: dict[int, float]) -> list[float]:
    return [seconds + by.get(i, 0.0) for i, seconds in enumerate(lengths)]


FEWEST, MOST = 8, 18  # placements tried: fewer leave next to nothing for the residual to judge by
FIRST_TRIED_S = 50.0  # s, of a dwell at which an order is searched first
ROUNDS = 2  # of order and lengths in turn
SCANNED = 3  # beginnings of a search for every number of placements; the best number is searched with more
PATIENCE = 3  # numbers of placements without a gain after which more of them are not tried
LONGEST_MIN = 60.0  # min: what is not met within is reported to be out of reach


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
    """Return the shortest campaign of as many placements that more beginnings of the search find."""
    n, hands = len(best.positions), sigmas.steps.hands
    tail, seconds = best.placements[n:], float(np.mean([at.seconds for at in best.placements[:n]]))
    other, _ = OrderSearch(sigmas, wanted, seconds, tail=tail).best(n, seed + 1)
    equal = equal_lengths(sigmas, wanted, other)
    found = [best] if equal is None else [best, shortened(sigmas, wanted, equal)]
    return min(found, key=lambda each: each.seconds(hands))


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


def _fitting(sigmas: DesignSigmas, minutes: float, tail: Sequence[Placement]) -> Iterator[tuple[int, float]]:
    """Give numbers of placements and the length [s] that their dwells have in a time."""
    for n in range(FEWEST, MOST + 1):
        left = minutes * S_PER_MIN - _least_seconds(sigmas, n, tail)
        if left >= 0:
            yield n, SHORTEST_S + left / n // LENGTH_STEP_S * LENGTH_STEP_S


def planned(sigmas: DesignSigmas, wanted: WantedSigmas, design: CampaignDesign) -> PlannedCampaign:
    """Return a design with its sigmas."""
    found = sigmas.of(design)
    return PlannedCampaign(design, found, bool(wanted.worst(found) <= 1))


def _tails(turns: bool) -> Iterator[Sequence[Placement]]:
    yield ()
    if turns:
        yield ROTATION_PLACEMENTS


def _least_seconds(sigmas: DesignSigmas, n: int, tail: Sequence[Placement]) -> float:
    hands = sigmas.steps.hands
    return n * (hands.placing + SHORTEST_S) + len(tail) * hands.turn


def _shortest(
    sigmas: DesignSigmas, wanted: WantedSigmas, n: int, tail: Sequence[Placement], seed: int
) -> CampaignDesign | None:
    """Return the shortest campaign of n dwells, None if it cannot meet what is wanted."""
    found, _ = OrderSearch(sigmas, wanted, FIRST_TRIED_S, tail=tail).best(n, seed, SCANNED)
    best = equal_lengths(sigmas, wanted, found)
    if best is None:
        return None
    for _ in range(ROUNDS):
        seconds = best.placements[0].seconds
        found, _ = OrderSearch(sigmas, wanted, seconds, tail=tail).improved(best)
        shorter = equal_lengths(sigmas, wanted, found)
        if shorter is None or shorter.placements[0].seconds >= seconds:
            break
        best = shorter
    return shortened(sigmas, wanted, best)


MOST_TRIED = 4  # numbers of placements to come, from the fewest that may do


@dataclass(frozen=True, slots=True, eq=False)
class NextPlacement:
    """The placement that comes next, ``seconds`` that are left, 1 sigma (30,) of what was done.

    ``placing`` is None to stop, as all is met or, not reachable, as no attitude is left.
    ``way`` is the whole campaign that it belongs to, what was done first. ``is_reachable`` says whether what is
    wanted can be met; where not, the next placement is the best all the same.
    """

    placing: Placement | None
    seconds: float
    sigmas: FloatArray
    way: CampaignDesign
    is_reachable: bool = True


def next_placement(
    sigmas: DesignSigmas, wanted: WantedSigmas, done: Sequence[Placement], *, seed: int = 0, goes_on: bool = False
) -> NextPlacement:
    """Return what to do after the placements ``done``, which may be none; ``goes_on`` when all is met as well."""
    if not done:
        found = least_time(sigmas, wanted, turns=False, seed=seed)
        nothing = np.full(len(found.sigmas), np.inf)
        left = found.design.seconds(sigmas.steps.hands)
        return NextPlacement(found.design.placements[0], left, nothing, found.design, found.is_met)
    so_far = CampaignDesign(tuple(done))
    now = sigmas.of(so_far)
    if not goes_on and is_enough(sigmas, wanted, so_far):
        return NextPlacement(None, 0.0, now, so_far)
    if not OrderSearch(sigmas, wanted, SHORTEST_S, head=done).can_go_on():  # every attitude was taken
        return NextPlacement(None, 0.0, now, so_far, is_reachable=is_enough(sigmas, wanted, so_far))
    ways = [_way(sigmas, wanted, done, n, seed) for n in _numbers(len(so_far.positions))]
    hands = sigmas.steps.hands
    best = min(ways, key=lambda way: (not is_met(sigmas, wanted, way), way.seconds(hands)))
    left = best.seconds(hands) - so_far.seconds(hands)
    return NextPlacement(best.placements[len(done)], left, now, best, is_met(sigmas, wanted, best))


def is_enough(sigmas: DesignSigmas, wanted: WantedSigmas, so_far: CampaignDesign) -> bool:
    """Say whether what was done has all that is wanted, in placements enough to judge its residual by."""
    return len(so_far.positions) >= FEWEST and is_met(sigmas, wanted, so_far)


def _numbers(done: int) -> range:
    fewest = max(FEWEST - done, 1)
    return range(fewest, max(min(fewest + MOST_TRIED, MOST + 1 - done), fewest + 1))


def _way(
    sigmas: DesignSigmas, wanted: WantedSigmas, done: Sequence[Placement], n: int, seed: int
) -> CampaignDesign:
    """Return a campaign that goes on with n placements, as short as meet what is wanted, else the longest."""
    known = [at.seconds for at in done if at.turn is None]
    found, _ = OrderSearch(sigmas, wanted, float(np.median(known)), head=done).best(n, seed, SCANNED)
    n = len(found.positions) - len(known)  # fewer where no more attitudes are left
    return _shortest_equal(sigmas, wanted, lambda seconds: found.lasting([*known, *[seconds] * n]))
