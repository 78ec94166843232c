"""The wire formats: to add one, write its file and name it in `FORMATS`; the family tests pick it up."""

from drivers.wire import ch70, counts, kvh1750, rawimu, rawimus, rawimusx, rawimux, stim300, triad
from drivers.wire._format import (
    ALL_CHANNELS,
    FrameKind,
    Identity,
    JoinCounters,
    Joiner,
    Lines,
    NominalScale,
    WireFormat,
)

FORMATS: dict[str, WireFormat] = {
    wire.name: wire
    for wire in (
        rawimusx.FORMAT,
        rawimus.FORMAT,
        rawimux.FORMAT,
        rawimu.FORMAT,
        rawimusx.ASCII,
        rawimus.ASCII,
        rawimux.ASCII,
        rawimu.ASCII,
        counts.FORMAT,
        stim300.FORMAT,
        kvh1750.FORMAT,
        ch70.FORMAT,
        triad.FORMAT,
    )
}

__all__ = [
    "ALL_CHANNELS",
    "FORMATS",
    "FrameKind",
    "Identity",
    "JoinCounters",
    "Joiner",
    "Lines",
    "NominalScale",
    "WireFormat",
]
