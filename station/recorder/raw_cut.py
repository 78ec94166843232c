"""Where frames stand in bytes, so that a step's raw bytes are those of its samples and no others."""

from drivers.wire import WireFormat


def frame_edges(wire: WireFormat, before: bytes, data: bytes) -> list[tuple[int, int]]:
    """Return begin and end of the intact IMU frames that end in ``data``, counted from its first byte.

    They are found as `drivers.framing.Decoder` finds them. A begin is negative where the frame began in
    ``before``.
    """
    whole, offset = before + data, len(before)
    kinds, head, edges, at = wire.kinds, len(wire.imu.prefix), list[tuple[int, int]](), 0
    while (at := whole.find(wire.sync, at)) >= 0:
        kind = kinds.get(whole[at : at + head])
        if kind is not None and at + kind.size <= len(whole) and wire.is_intact(whole[at : at + kind.size]):
            if kind is wire.imu and at + kind.size > offset:
                edges.append((at - offset, at + kind.size - offset))
            at += kind.size
        else:
            at += 1
    return edges


def longest_frame(wire: WireFormat) -> int:
    """Return the bytes of the longest kind of frame."""
    return max(kind.size for kind in wire.kinds.values())
