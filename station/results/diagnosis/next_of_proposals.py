"""The measurement that parts a proposal's readings, in words and as steps of `plan/1`: a line an option."""

from collections.abc import Iterable, Mapping

from procedures.discovery.discover import Discovery, Proposal
from procedures.discovery.next_plan import HEATED_K, LONGER, SPEEDS_DEG_S, NextMeasurement, next_measurement
from station.results.diagnosis.next_measurements import (
    DWELL_S,
    MIXED,
    OTHER_ORDER,
    Make,
    Measurement,
    always,
    positions,
    turns,
)

MEASUREMENTS: Mapping[str, Make] = {
    **{
        f"turns_at_{speed:g}": always(
            f"turns_at_{speed:g}",
            f"Turn about each axis once more, both ways, at about {speed:g} deg/s.",
            turn=turns(speed_deg_s=speed),
        )
        for speed in SPEEDS_DEG_S
    },
    "another_order": OTHER_ORDER,
    "heated": always(
        "heated",
        f"Do the twelve positions and the turns again while the unit is heated by {HEATED_K:g} K, evenly from the "
        f"first step to the last.",
        **positions(MIXED),
        turn=turns(),
    ),
    "longer_rests": always(
        "longer_rests",
        f"Do the twelve positions again, each for {LONGER * DWELL_S:g} s.",
        **positions(range(1, 13), LONGER * DWELL_S),
    ),
}


def parted_by(found: Discovery) -> list[NextMeasurement | None]:
    """Return the measurement that parts each proposal's readings, None where it has none or nothing parts them."""
    return [next_measurement(found, one) for one in found.proposals]


def next_said(one: Proposal, best: NextMeasurement | None) -> str:
    """Return what to measure next to part a proposal from its readings; nothing where there are none."""
    if not one.readings:
        return ""
    if best is None:
        return "no repetition of this campaign's steps parts it from them"
    say = MEASUREMENTS[best.name]({}, ()).say.rstrip(".")
    return f"{say}: parts it from {best.parted} of them, in {best.minutes:.0f} minutes at the bench"


def planned(names: Iterable[str]) -> list[Measurement]:
    """Return the measurements of some options, each once."""
    return [MEASUREMENTS[name]({}, ()) for name in dict.fromkeys(names)]
