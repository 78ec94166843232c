"""CRC-32/MPEG-2: polynomial 04C11DB7, initial FFFFFFFF, not reflected, no final XOR; of 123456789 it is 0376E6E7.

zlib computes the reflected CRC-32. The bits of every byte turned round make one of the other, and
`bytes.translate` turns them as fast as zlib reads them.
"""

import zlib

from drivers.wire._format import Octets

TURNED = bytes(int(f"{octet:08b}"[::-1], 2) for octet in range(256))
PASSED = 0xFFFFFFFF  # zlib's value over anything followed by its own CRC, here without the final XOR


def crc(data: Octets) -> int:
    """Return the CRC of ``data``."""
    register = zlib.crc32(bytes(data).translate(TURNED)) ^ 0xFFFFFFFF
    return int.from_bytes(register.to_bytes(4, "little").translate(TURNED), "big")


def is_intact(frame: Octets) -> bool:
    """Say whether a frame passes that ends with its own CRC, big-endian."""
    return zlib.crc32(bytes(frame).translate(TURNED)) == PASSED


def is_intact_padded(frame: Octets) -> bool:
    """Say the same where the CRC was taken over zero bytes too, to a multiple of 4, that are not sent."""
    turned = bytes(frame).translate(TURNED)
    register = zlib.crc32(turned[:-4])
    return zlib.crc32(turned[-4:], zlib.crc32(bytes(-len(turned) % 4), register)) == PASSED
