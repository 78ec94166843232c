"""Checks of frames that formats share: CRC-32/MPEG-2, and the field of a check filled in.

A check that one maker alone uses stands in the file of its format; those of CAN in `drivers.can.mapping_file`.
"""

import zlib
from collections.abc import Callable

from drivers.wire.wire_format import Frames, Octets


def seal(frames: Frames, crc: Callable[[Octets], int]) -> bytes:
    """Return the bytes of ``frames``, the last field ``crc`` computed over all that stands before it."""
    size, view = frames.dtype.itemsize, memoryview(frames.tobytes())
    end = frames.dtype.fields["crc"][1] if frames.dtype.fields else size
    frames["crc"] = [crc(view[at : at + end]) for at in range(0, len(view), size)]
    return frames.tobytes()


# CRC-32/MPEG-2 by zlib, whose CRC-32 is reflected: with the bits of every byte reversed one makes the other
_REVERSED = bytes(int(f"{octet:08b}"[::-1], 2) for octet in range(256))
_PASSED = 0xFFFFFFFF  # zlib's value over anything followed by its own CRC, here without the final XOR


def mpeg2_crc(data: Octets) -> int:
    """Return CRC-32/MPEG-2 of ``data``; of the ASCII string 123456789 it is 0376E6E7.

    Polynomial 04C11DB7, initial value FFFFFFFF, not reflected, no final XOR.
    """
    register = zlib.crc32(bytes(data).translate(_REVERSED)) ^ 0xFFFFFFFF
    return int.from_bytes(register.to_bytes(4, "little").translate(_REVERSED), "big")


def mpeg2_is_intact(frame: Octets) -> bool:
    """Say whether a frame ends with its own CRC-32/MPEG-2, big-endian."""
    return zlib.crc32(bytes(frame).translate(_REVERSED)) == _PASSED


def mpeg2_is_intact_padded(frame: Octets) -> bool:
    """Say the same where the CRC was taken over zero bytes too, to a multiple of 4, that are not sent."""
    turned = bytes(frame).translate(_REVERSED)
    register = zlib.crc32(turned[:-4])
    return zlib.crc32(turned[-4:], zlib.crc32(bytes(-len(turned) % 4), register)) == _PASSED
