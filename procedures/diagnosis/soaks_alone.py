"""Recordings at rest that determine no calibration: what moves within them is diagnosed all the same.

The base model is a constant for each recording and sensor. Scale factors are those of the units that were told,
misalignment is none; where no unit was told the output is its own unit. A long dwell or rest is a soak as well.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from procedures.calibration.joint_calibration import CampaignFits
from procedures.calibration.solution_values import FitQuality, Solution
from procedures.campaign.campaign import Campaign, DwellRecord, RestRecord, SoakRecord
from procedures.evidence.candidates import Candidate, raising_does_not_fit
from procedures.evidence.excitation import NodeBuilder
from procedures.evidence.refit import Refit, iterate
from procedures.evidence.residual_rows import evidence_of
from procedures.evidence.thermal_soaks import BLOCK_S, MIN_BLOCKS, soaks_seen
from procedures.inference.result import TableSensor
from procedures.statistics.significance import log_chi2_sf

LONG_REST_S = 2 * MIN_BLOCKS * BLOCK_S  # of a dwell that is a soak too


@dataclass(frozen=True, slots=True, eq=False)
class SoaksAlone:
    """Campaigns of which only the soaks are looked at; nothing of them is solved."""

    fits: CampaignFits

    @classmethod
    def of(cls, campaigns: Sequence[Campaign]) -> "SoaksAlone | None":
        """Return the soaks of one unit's campaigns, long rests among them; None if none has blocks enough."""
        found = cls(CampaignFits(tuple(_with_long_rests(each) for each in campaigns), None, None, None, None))
        if not any(campaign.soaks for campaign in found.fits.campaigns):
            return None
        return found if soaks_seen(found.fits, NodeBuilder(found.fits)) else None

    def refit(self, added: Sequence[Candidate]) -> Refit:
        """Fit constants and effects together.

        Raises
        ------
        DoesNotFit
            If they cannot be fitted with the effects in.
        """
        with raising_does_not_fit(bool(added)):
            return iterate(self.fits, evidence_of, lambda fits, *_: fits, lambda fits, *_: fits, added)

    def report(self, found: Refit) -> Solution:
        """Return how well the model fits: there is no calibration."""
        linear = found.linear
        chi2 = float(np.sum((linear.white * linear.factor) ** 2))
        dof = round(float(np.sum(1 - linear.leverage)))
        quality = FitQuality(chi2, dof, float(np.exp(log_chi2_sf(chi2, dof))))
        return Solution(None, None, None, None, quality, (), np.zeros((0, 0)), None)

    def on_table(self, found: Refit) -> tuple[TableSensor, ...]:
        """Return none: a rest is no table."""
        return ()


def _with_long_rests(campaign: Campaign) -> Campaign:
    held: list[DwellRecord | RestRecord] = [*campaign.dwells, *campaign.rests]
    more = tuple(_as_soak(each) for each in held if len(each.series) * each.series.period >= LONG_REST_S)
    return replace(campaign, soaks=(*campaign.soaks, *more))


def _as_soak(rest: DwellRecord | RestRecord) -> SoakRecord:
    if isinstance(rest, DwellRecord):
        return SoakRecord(rest.name, rest.position, None, rest.series)
    return SoakRecord(rest.name, 0, rest.up, rest.series)
