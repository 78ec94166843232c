"""What the engine needs of a campaign, and what came of it."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from station.guide.command import OperatorCommand
from station.guide.setup_view import PortCheck
from station.guide.view import CalibrationView, Verdict
from station.stream.stream_events import Sound

if TYPE_CHECKING:
    from station.guide.disk_space import DiskSpace
    from station.results.campaign_results import CampaignResults


class GuidedCampaign(Protocol):
    """A campaign under way, on a device or complete."""

    has_device: bool  # whether its IMU is being read

    @property
    def is_complete(self) -> bool:
        """Whether nothing is left to record."""
        ...

    @property
    def folder(self) -> Path:
        """Where it is recorded."""
        ...

    @property
    def disk(self) -> "DiskSpace":
        """The room that what is left to do needs, and what there is."""
        ...

    def round(self) -> None:
        """Go on for a moment."""
        ...

    def view(self, base: CalibrationView) -> CalibrationView:
        """Return ``base`` with everything filled in."""
        ...

    def obey(self, command: OperatorCommand) -> None:
        """Do as the operator says."""
        ...

    def say(self, sound: Sound, text: str) -> None:
        """Tell the operator."""
        ...

    def as_checked(self) -> PortCheck | None:
        """Return what a look at its port says of the unit, None where none is read."""
        ...

    def close(self) -> None:
        """Let device and folder go; may be called twice."""
        ...


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
