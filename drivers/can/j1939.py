"""J1939 identifiers: a message is known by its PGN; who sent it and how urgently stand in the other bits.

29 bits are priority (3), extended data page and data page, PDU format PF (8), PDU specific PS (8), source address
(8). Where PF is below 240 (PDU1) PS is the destination's address, else (PDU2) it belongs to the PGN. Devices claim
their source address on the bus, so what a DBC says of it is an example. Source: SAE J1939-21, 5.2 and 5.3.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from drivers.can.frame_record import ERROR, EXTENDED, REMOTE
from drivers.errors import BadCanFile

ALL_BITS = 0xFFFFFFFF
FLAGS = EXTENDED | REMOTE | ERROR
PAGES_AND_FORMAT, SPECIFIC, SOURCE = 0x03FF0000, 0xFF00, 0xFF
FIRST_PDU2 = 240
NULL_ADDRESS = 0xFE  # of nobody: a DBC that has it names no sender


def pgn_mask(identifier: int) -> int:
    """Return the bits of an identifier, flags included, that say what a frame holds: all of one of 11 bits."""
    if not identifier & EXTENDED:
        return ALL_BITS
    return FLAGS | PAGES_AND_FORMAT | (SPECIFIC if (identifier >> 16) & 0xFF >= FIRST_PDU2 else 0)


def pgn_of(identifier: int) -> int:
    """Return the parameter group number of an identifier of 29 bits."""
    return (identifier & pgn_mask(identifier) & ~FLAGS) >> 8


def is_pgn_shared(identifier: int, others: Iterable[int]) -> bool:
    """Say whether other messages have the same PGN: then the other bits tell them apart, and all count."""
    mask = pgn_mask(identifier)
    return any((other ^ identifier) & mask == 0 for other in others)


class SenderWatch:
    """Holds the frames of what a DBC calls one sender to one source address; two devices are never mixed.

    ``path`` is the file that has to say which is meant, and ``remedy`` how, with the addresses put into it.
    """

    def __init__(self, path: str, remedy: str = "say source_address = {} in it") -> None:
        self._path, self._remedy = path, remedy
        self._sources = dict[int, int]()  # the address that frames came from, by the DBC's

    def look(self, sender: int, identifiers: NDArray[np.uint32]) -> None:
        """Take the 29-bit numbers ``identifiers`` (n,) of a sender's frames.

        Raises
        ------
        BadCanFile
            If they come from two addresses: which is meant the mapping must say.
        """
        addresses = identifiers & SOURCE
        known = self._sources.setdefault(sender, int(addresses[0]))
        if len(other := np.flatnonzero(addresses != known)):
            second = int(identifiers[other[0]])
            both = [f"0x{address:02X}" for address in sorted((known, second & SOURCE))]
            found = f"PGN {pgn_of(second)} from source addresses {' and '.join(both)}, two devices"
            raise BadCanFile(self._path, None, found, f"one; {self._remedy.format(' or '.join(both))}")
