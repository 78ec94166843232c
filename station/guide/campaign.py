"""A campaign as the engine has it, and what came of it."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from station.guide.view import Verdict

if TYPE_CHECKING:
    from station.guide.finished_campaign import FinishedCampaign
    from station.guide.live_campaign import LiveCampaign
    from station.results.campaign_results import CampaignResults

    GuidedCampaign = LiveCampaign | FinishedCampaign  # under way, or complete and without a device


@dataclass(frozen=True, slots=True, eq=False)
class SolveOutcome:
    """What came of a campaign; empty until it was solved."""

    verdict: Verdict | None = None
    results: "CampaignResults | None" = None
    sha256: str = ""

    def shown(self) -> dict[str, object]:
        """Return the view's fields."""
        assert self.verdict is not None
        verdict = self.verdict.model_copy(update={"stored_sha256": self.sha256})
        stage = "stored" if self.sha256 else "verdict"
        return {"stage": stage, "line": verdict.sentence, "hint": "", "verdict": verdict, "live": "", "wanted": ""}
