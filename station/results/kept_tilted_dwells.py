"""Positions whose recording was kept though the cube sat tilted, as a campaign says it."""

import numpy as np

from procedures.bench.seating_check import PLAUSIBLE_FACE_TILT_RAD
from procedures.campaign.plan_steps import Dwell
from station.files.campaign_folder.campaign_schema import CampaignTable
from station.stream.recorder.accepted_step_writer import step_of


def kept_seats(tables: CampaignTable) -> list[tuple[Dwell, float]]:
    """Return the dwells whose cube was kept off its seat, by how far [rad], the worst first."""
    off = [
        (step, float(np.linalg.norm(dwell.kept_seat_rad)))
        for dwell in tables.dwell
        if dwell.kept_seat_rad is not None and isinstance(step := step_of(dwell), Dwell)
    ]
    return sorted(off, key=lambda each: each[1], reverse=True)


def worst_kept(tables: CampaignTable) -> str:
    """Return the name of the step kept farthest off its seat, empty if there is none."""
    return next((step.name for step, _ in kept_seats(tables)), "")


def doubt_of(tables: CampaignTable) -> str:
    """Return what a verdict must say first where a kept seat is off by more than a cube's own faces may be.

    Such a step stands in the fit as if it were level, and the limits cannot tell. Empty where there is none.
    """
    bad = {step: off for step, off in kept_seats(tables) if off > PLAUSIBLE_FACE_TILT_RAD}
    if not bad:
        return ""
    which = " and ".join(f"position {step.words}" for step in sorted(bad, key=lambda each: each.name))
    return (
        f"do not use this result, record {which} again: it was kept although the cube was tilted by "
        f"{'up to ' if len(bad) > 1 else ''}{np.degrees(max(bad.values())):.2g} deg"
    )
