"""The wire formats: to add one, write its file and name it in `FORMATS`; the family tests pick it up."""

from drivers.wire import ch70, counts, kvh1750, novatel_raw_imu, stim300, triad
from drivers.wire._format import (
    ALL_CHANNELS,
    FrameCounters,
    FrameKind,
    Identity,
    Joiner,
    Lines,
    NominalScale,
    PulseForm,
    WireFormat,
)

FORMATS: dict[str, WireFormat] = {
    wire.name: wire
    for wire in (
        *novatel_raw_imu.FORMATS,
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
    "FrameCounters",
    "FrameKind",
    "Identity",
    "Joiner",
    "Lines",
    "NominalScale",
    "PulseForm",
    "WireFormat",
]
