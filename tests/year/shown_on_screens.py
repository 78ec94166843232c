"""What the screens showed of a campaign, and how its cube then stood."""

from collections import Counter
from dataclasses import dataclass, field

from station.guide.view import Verdict


@dataclass
class Reported:
    """What the screens showed of a campaign, over all its sessions."""

    shown: Counter[str] = field(default_factory=Counter)  # accepted recordings by step, as shown last
    tilts: dict[str, float] = field(default_factory=dict)  # how far off its seat [rad] the cube stood, by step
    turned: dict[str, float] = field(default_factory=dict)  # how far off its marks [rad], by step
    verdict: Verdict | None = None
    certificate: str = ""  # its hash, or what it lacks
    unsolved: str = ""
    refused: list[str] = field(default_factory=list)
    kills: int = 0
    sessions: int = 0
