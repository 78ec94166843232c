"""Positions whose recording was kept though the cube sat tilted, as a campaign says it."""

import numpy as np

from procedures.steps import Dwell
from station.campaign_folder.schema import CampaignTable


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
