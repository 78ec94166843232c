"""Where frames begin in bytes, so that a step's raw bytes are those of its samples and no others."""

from drivers.wire import WireFormat


def frame_starts(wire: WireFormat, data: bytes) -> list[int]:
    """Return where the intact IMU frames of ``data`` begin, found as `drivers.framing.Decoder` finds them."""
    kinds, head, starts, at = wire.kinds, len(wire.imu.prefix), list[int](), 0
    while (at := data.find(wire.sync, at)) >= 0:
        kind = kinds.get(data[at : at + head])
        if kind is not None and at + kind.size <= len(data) and wire.is_intact(data[at : at + kind.size]):
            if kind is wire.imu:
                starts.append(at)
            at += kind.size
        else:
            at += 1
    return starts


def longest_frame(wire: WireFormat) -> int:
    """Return the bytes of the longest kind of frame."""
    return max(kind.size for kind in wire.kinds.values())


def cut(wire: WireFormat, before: bytes, data: bytes, first: int, last: int | None) -> bytes:
    """Return the bytes from the start of frame ``first`` to the end of frame ``last``, or of ``data`` if None.

    Frames are counted among those that end in ``data``; the first of them may begin in ``before``.
    """
    whole = before + data
    ends = [at + wire.imu.size for at in frame_starts(wire, whole) if at + wire.imu.size > len(before)]
    begin = ends[first] - wire.imu.size if first else min(ends[0] - wire.imu.size, len(whole))
    return whole[begin : len(whole) if last is None else ends[last]]
