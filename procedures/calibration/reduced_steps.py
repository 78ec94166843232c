"""What the steps of campaigns say, before anything is fitted: rates of dwells and rests, totals of turns."""

from collections.abc import Sequence
from dataclasses import dataclass

from procedures.campaign.campaign import Campaign, RestRecord
from procedures.campaign.dead_channels import without_dead
from procedures.campaign.observations import (
    TriadDwells,
    TriadRests,
    TurnTotal,
    dwell_rates,
    rest_rates,
    turn_totals,
)
from procedures.free_positions.gyroscopes_from_moves import SegmentedSequence, all_rests, segment
from procedures.twelve_positions.rotation_tilt import turn_rests


@dataclass(frozen=True, slots=True, eq=False)
class ReducedSteps:
    """What the steps of campaigns say, before anything is fitted; ``rests`` are those of ``others`` with rates.

    ``turn_rests`` are those before and after the turns, two of each, by the accelerometers.
    """

    campaigns: tuple[Campaign, ...]
    accel: TriadDwells | None
    gyro: TriadDwells | None
    segmented: tuple[SegmentedSequence, ...]
    others: tuple[tuple[int, RestRecord], ...]
    rests: TriadRests | None
    turns: tuple[TurnTotal, ...]
    left_out: tuple[str, ...] = ()
    turn_rests: TriadRests | None = None


def reduce_steps(
    campaigns: Sequence[Campaign], accel_known: TriadDwells | None = None, gyro_known: TriadDwells | None = None
) -> ReducedSteps:
    """Reduce dwells, rests and turns to rates and totals, those of dead channels left out.

    Rates of the very same dwells are taken from those that are known.
    """
    campaigns, left_out = without_dead(campaigns)
    accel = dwell_rates(campaigns, "accelerometer", accel_known)
    gyro = dwell_rates(campaigns, "gyroscope", gyro_known)
    segmented = segment(campaigns)
    others = all_rests(campaigns, segmented)
    turns = turn_totals(campaigns, gyro.noise) if gyro is not None else []
    rests = rest_rates(others, "accelerometer")
    return ReducedSteps(
        campaigns, accel, gyro, segmented, tuple(others), rests, tuple(turns), left_out, turn_rests(turns)
    )
