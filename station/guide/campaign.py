"""What the engine needs of a campaign."""

from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from station.guide.command import Command
from station.guide.setup_view import Check
from station.guide.view import View
from station.stream.events import Sound

if TYPE_CHECKING:
    from station.guide.disk_space import Disk


class Campaign(Protocol):
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
    def disk(self) -> "Disk":
        """The room that what is left to do needs, and what there is."""
        ...

    def round(self) -> None:
        """Go on for a moment."""
        ...

    def view(self, base: View) -> View:
        """Return ``base`` with everything filled in."""
        ...

    def obey(self, command: Command) -> None:
        """Do as the operator says."""
        ...

    def say(self, sound: Sound, text: str) -> None:
        """Tell the operator."""
        ...

    def as_checked(self) -> Check | None:
        """Return what a look at its port says of the unit, None where none is read."""
        ...

    def close(self) -> None:
        """Let device and folder go; may be called twice."""
        ...
