"""What is no column of a linear model and is settled before one is asked: labels, shocks and the clock.

Each is put right in memory, and the rest of the diagnosis looks at the campaigns as they then are: at dwells in
the positions where they stood, without disturbed stretches, in true seconds.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from procedures.anomalies.clock_rate_check import find_clock, is_timed, with_true_clock
from procedures.anomalies.disturbances import find_disturbances, without_disturbances
from procedures.anomalies.wrong_positions import (
    find_wrong_labels,
    label_findings,
    with_true_directions,
    with_true_labels,
)
from procedures.campaign.campaign import Campaign, DwellRecord
from procedures.gyrocompass import first_position
from procedures.inference.result import EffectTest, Finding
from procedures.units import PPM_PER_ONE


@dataclass(frozen=True, slots=True, eq=False)
class CheckedCampaigns:
    """The campaigns put right, the findings and tests made on the way, and the effects so ``settled``, by name.

    ``clock`` is the relative 1 sigma of the clock's rate by which times were put right, None where they were not.
    """

    campaigns: tuple[Campaign, ...]
    findings: tuple[Finding, ...]
    tests: tuple[EffectTest, ...]
    settled: frozenset[str]
    clock: float | None = None


def check_campaigns(campaigns: Sequence[Campaign]) -> CheckedCampaigns:
    """Put one unit's campaigns right; a clock that may as well be a wrongly stated period is left alone.

    Labels are looked at without the moves, which would contradict a wrong one.
    """
    moves = [campaign.moves for campaign in campaigns]
    campaigns = [replace(campaign, moves=()) for campaign in campaigns]
    campaigns, directions = with_true_directions([_faces_as_positions(campaign) for campaign in campaigns])
    wrong = find_wrong_labels(campaigns)
    labels = label_findings(campaigns, wrong)
    campaigns = with_true_labels(campaigns, wrong)
    disturbed, disturbance_tests = find_disturbances(campaigns)
    campaigns = without_disturbances(campaigns, disturbed)
    campaigns = [replace(campaign, moves=each) for campaign, each in zip(campaigns, moves, strict=True)]
    clock, clock_tests = find_clock(campaigns)
    settled = {"placement.label", "disturbance.dwell"} | ({"clock.rate"} if is_timed(campaigns) else set())
    clock_std = None
    for each in clock:
        if not each.aliases:
            campaigns = with_true_clock(campaigns, float(each.value[0]))
            clock_std = float(each.std[0]) / PPM_PER_ONE
    findings = (*directions, *labels[0], *(one.finding for one in disturbed), *clock)
    tests = (*labels[1], *disturbance_tests, *clock_tests)
    return CheckedCampaigns(tuple(campaigns), findings, tests, frozenset(settled), clock_std)


def _faces_as_positions(campaign: Campaign) -> Campaign:
    """Return a campaign whose rests on known faces stand in positions, if it has no positions of its own.

    To accelerometers a heading matters only through the slab's tilt, which the model holds within its range
    anyway: each rest is taken at its face's first position. The gyroscopes' horizontal Earth rate does hang on
    the heading: their outputs are left out.
    """
    on_face = [rest for rest in campaign.rests if rest.up is not None and rest.series.accel is not None]
    if campaign.dwells or not on_face:
        return campaign
    dwells = tuple(
        DwellRecord(rest.name, first_position(rest.up), replace(rest.series, gyro=None))
        for rest in on_face
        if rest.up is not None
    )
    return replace(campaign, dwells=dwells, rests=tuple(rest for rest in campaign.rests if rest.up is None))
