"""Positions whose recording was kept though the cube sat tilted, as a campaign says it."""

import numpy as np

from procedures.bench.seating_check import PLAUSIBLE_FACE_TILT_RAD
from procedures.campaign.plan_steps import Dwell
from station.files.campaign_folder.campaign_schema import CampaignTable


def kept_seats(tables: CampaignTable) -> dict[int, float]:
    """Return by position how far off the cube was kept [rad], the worst first."""
    off = {
        dwell.position: float(np.linalg.norm(dwell.kept_seat_rad))
        for dwell in tables.dwell
        if dwell.position is not None and dwell.kept_seat_rad is not None
    }
    return dict(sorted(off.items(), key=lambda item: item[1], reverse=True))


def worst_kept(tables: CampaignTable) -> str:
    """Return the name of the step kept farthest off its seat, empty if there is none."""
    return next((Dwell(position, 0.0).name for position in kept_seats(tables)), "")


def doubt_of(tables: CampaignTable) -> str:
    """Return what a verdict must say first where a kept seat is off by more than a cube's own faces may be.

    Such a step stands in the fit as if it were level, and the limits cannot tell. Empty where there is none.
    """
    bad = {position: off for position, off in kept_seats(tables).items() if off > PLAUSIBLE_FACE_TILT_RAD}
    if not bad:
        return ""
    which = " and ".join(f"position {position}" for position in sorted(bad))
    return (
        f"do not rely on it, record {which} again: kept though the cube sat tilted by "
        f"{'up to ' if len(bad) > 1 else ''}{np.degrees(max(bad.values())):.2g} deg"
    )
