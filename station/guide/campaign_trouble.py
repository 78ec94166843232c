"""What is wrong with the stream of a campaign: two words for it, and the one thing to do."""

from dataclasses import dataclass
from typing import Self

from drivers.errors import DeadChannel, DriverError, WrongFormat
from station.stream.recorder.connected_unit import UnitChanged


@dataclass(frozen=True, slots=True)
class TroubleView:
    """``word`` stands in the place of what is live; ``instruction`` is what to do; the error says the rest."""

    word: str
    instruction: str

    @classmethod
    def none(cls) -> Self:
        """Return what there is while all is well."""
        return cls("", "")


def trouble_of(error: DriverError) -> TroubleView:
    """Return what an error of the stream is to the operator."""
    if isinstance(error, UnitChanged):
        return TroubleView("WRONG UNIT", "connect the campaign's own unit; it goes on by itself")
    if isinstance(error, WrongFormat):
        return TroubleView("NOT READABLE", "check format and baud rate; it goes on by itself")
    if isinstance(error, DeadChannel):
        return TroubleView("DEAD CHANNEL", "check its wiring and supply; it goes on by itself")
    return TroubleView("NO DATA", "check cable and power; it goes on by itself")
