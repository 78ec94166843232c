"""What is told of a live stream: events to be heard and read, and the health of each stream."""

from dataclasses import dataclass
from typing import Literal

from pydantic import BaseModel, ConfigDict

EVENTS_FILE = "events.csv"  # of a recorded run
Sound = Literal["", "start", "still", "accepted", "rejected"]


class Event(BaseModel):
    """Something to be heard and read once; ``number`` rises."""

    model_config = ConfigDict(extra="forbid", frozen=True)
    number: int
    sound: Sound
    text: str


@dataclass(frozen=True, slots=True)
class StreamState:
    """The health of one stream: ``age_s`` since the newest sample, ``trouble`` what is wrong, empty if nothing."""

    name: str
    rate_hz: float
    age_s: float
    samples: int
    gaps: int
    lost: int
    bad: int
    unhealthy: int = 0
    trouble: str = ""
