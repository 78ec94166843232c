"""The wire formats: to add one, write its file and name it in `FORMATS`; the family tests pick it up."""

from drivers.wire import counts, rawimus, rawimusx
from drivers.wire._format import FrameKind, Identity, JoinCounters, Joiner, NominalScale, WireFormat

FORMATS: dict[str, WireFormat] = {
    wire.name: wire
    for wire in (
        rawimusx.FORMAT,
        rawimus.FORMAT,
        counts.FORMAT,
    )
}

__all__ = ["FORMATS", "FrameKind", "Identity", "JoinCounters", "Joiner", "NominalScale", "WireFormat"]
