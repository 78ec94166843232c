"""What an operator can ask of the engine: one small frozen value, as JSON across a process border."""

from typing import Literal, Protocol

from station.files.campaign_setup import Setup
from station.guide.setup_view import FrozenValue
from station.guide.view import CalibrationView

CommandVerb = Literal[
    "check",  # look at the port `url` for two seconds
    "listen",  # to the GNSS receiver `url` for a few seconds
    "consider",  # `setup` as it stands: how ready is it
    "begin",  # a new campaign as `setup` says
    "resume",  # the campaign in `folder`
    "skip_warm_up",
    "choose",  # do `step` next
    "redo",  # do `step` again; empty: the one that `View.can_redo` names
    "pause",
    "go_on",
    "answer",  # the question, with `key`
    "keep_seating",  # accept the cube as it sits
    "finish",  # solve with what is there
    "more",  # one placing more though all that is wanted is met
    "store",  # the calibration: the operator's act
    "leave",  # end here, to be resumed
    "cancel",  # end here, the database as it was
]


class OperatorCommand(FrozenValue):
    """A verb and what belongs to it."""

    verb: CommandVerb
    setup: Setup | None = None
    url: str = ""
    folder: str = ""
    step: str = ""
    key: str = ""


class CalibrationSession(Protocol):
    """An engine as its screens see it, which know of no socket; both return at once."""

    @property
    def view(self) -> CalibrationView:
        """The newest view."""
        ...

    def send(self, command: OperatorCommand) -> None:
        """Ask something of the engine."""
        ...
