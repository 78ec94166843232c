"""Checks of a CAN payload, many at once. To add one: a function and a line in `CHECKS`.

Each takes identifiers (n,) and payloads (n, m) without the check's own byte, and returns (n,) what that byte
should be.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Check = Callable[[NDArray[np.uint32], Bytes], Bytes]


def _table(polynomial: int) -> Bytes:
    rows = []
    for value in range(256):
        for _ in range(8):
            value = (value << 1) ^ (polynomial if value & 0x80 else 0)
        rows.append(value & 0xFF)
    return np.array(rows, dtype=np.uint8)


_H2F, _J1850 = _table(0x2F), _table(0x1D)


def _crc(table: Bytes, octets: Bytes) -> Bytes:
    crc = np.full(len(octets), 0xFF, dtype=np.uint8)
    for column in octets.T:
        crc = table[crc ^ column]
    return crc ^ np.uint8(0xFF)


def crc8_autosar(_: NDArray[np.uint32], payloads: Bytes) -> Bytes:
    """Return CRC-8/AUTOSAR (n,) of payloads (n, m) [bytes], without the identifiers ``_`` (n,).

    Polynomial 2F, begins and ends with FF; of the ASCII string 123456789 it is DF.

    Source: AUTOSAR Specification of CRC Routines, CRC8H2F; Hamming distance 4 up to 119 bits.
    """
    return _crc(_H2F, payloads)


def crc8_autosar_id(identifiers: NDArray[np.uint32], payloads: Bytes) -> Bytes:
    """Return the same over the identifier, as four bytes with the high one first, and then the payload.

    On the bus CAN's own CRC guards an identifier; the text between adapter and station has no check at all.
    """
    names = identifiers.astype(">u4").view(np.uint8).reshape(-1, 4)
    return _crc(_H2F, np.hstack((names, payloads)))


def crc8_j1850(_: NDArray[np.uint32], payloads: Bytes) -> Bytes:
    """Return CRC-8/SAE-J1850 (n,) of payloads (n, m) [bytes], without the identifiers ``_`` (n,).

    Polynomial 1D, begins and ends with FF; of the ASCII string 123456789 it is 4B.
    """
    return _crc(_J1850, payloads)


def xor8(_: NDArray[np.uint32], payloads: Bytes) -> Bytes:
    """Return the exclusive or (n,) of payloads (n, m) [bytes], without the identifiers ``_`` (n,)."""
    result: Bytes = np.bitwise_xor.reduce(payloads, axis=1)
    return result


CHECKS: dict[str, Check] = {
    "crc8-autosar": crc8_autosar,
    "crc8-autosar-id": crc8_autosar_id,
    "crc8-j1850": crc8_j1850,
    "xor8": xor8,
}
