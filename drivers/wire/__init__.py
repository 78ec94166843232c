"""The wire formats: the bytes of a device to blocks of counts, and back.

A file describes frames by `wire_format`, checks them by `checksums` and gives its ``FORMATS``; `MODULES` lists
the files. NovAtel's take two: `novatel` (the logs and their text form) and `novatel_binary`. `drivers.framing`
finds the frames in a stream.
"""

from importlib import import_module

from drivers.wire.frame_counters import FrameCounters
from drivers.wire.wire_format import (
    ALL_CHANNELS,
    FrameKind,
    Identity,
    Joiner,
    Lines,
    NominalScale,
    PulseForm,
    WireFormat,
)

MODULES = (  # files of this folder, in the order in which bytes of an unknown format are compared with them
    "novatel",
    "counts",
    "stim300",
    "kvh1750",
    "ch70",
    "triad",
)
FORMATS: dict[str, WireFormat] = {
    wire.name: wire for name in MODULES for wire in import_module(f"drivers.wire.{name}").FORMATS
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
