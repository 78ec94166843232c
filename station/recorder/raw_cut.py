"""Where frames stand in bytes, so that a step's raw bytes are those of its samples and no others."""

from drivers import framing
from drivers.wire import WireFormat


def frame_edges(wire: WireFormat, before: bytes, data: bytes) -> list[tuple[int, int]]:
    """Return begin and end of the intact IMU frames that end in ``data``, counted from its first byte.

    They are found as `drivers.framing.Decoder` finds them. A begin is negative where the frame began in
    ``before``.
    """
    offset = len(before)
    edges = framing.frame_edges(wire, before + data)
    return [(begin - offset, end - offset) for begin, end in edges if end > offset]


def longest_frame(wire: WireFormat) -> int:
    """Return the bytes of the longest kind of frame."""
    return max(kind.size for kind in wire.kinds.values())
