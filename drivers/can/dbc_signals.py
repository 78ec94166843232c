"""A DBC file, read by cantools, and its signals taken out of many payloads at once.

A DBC counts a little-endian (Intel) signal's start from its lowest bit, a big-endian (Motorola) one's from its
highest, bit 0 being the lowest of byte 0. Read as one 64-bit word in the same byte order, either is a run of bits.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import cantools.database
import numpy as np
from cantools.database.can import Database, Message
from numpy.typing import NDArray

from drivers.can.frame_record import EXTENDED
from drivers.errors import BadCanFile
from drivers.text_decoding import decoded_text
from procedures.arrays import BoolArray, FloatArray, IntArray

Words = tuple[NDArray[np.uint64], NDArray[np.uint64]]  # (n,) each: payloads read little-endian, big-endian


@dataclass(frozen=True, slots=True)
class SignalField:
    """One signal: ``start`` as in the DBC, ``bits`` wide; ``scale`` and ``offset`` give it its ``unit``.

    ``least`` and ``most`` are what the DBC says that it can be, in that unit; infinite where it says nothing.
    """

    start: int
    bits: int
    is_big_endian: bool = False
    is_signed: bool = False
    is_float: bool = False
    scale: float = 1.0
    offset: float = 0.0
    unit: str = ""
    least: float = -np.inf
    most: float = np.inf

    @property
    def shift(self) -> int:
        """Where the lowest bit stands in the 64-bit word."""
        if not self.is_big_endian:
            return self.start
        byte, bit = divmod(self.start, 8)
        return 64 - (8 * byte + 7 - bit) - self.bits

    @property
    def mask(self) -> np.uint64:
        """As many ones as the signal has bits."""
        return np.uint64(2**self.bits - 1)

    def raw(self, words: Words) -> IntArray:
        """Return the signal (n,) as the integer sent; raise ValueError where it is a float or does not fit."""
        if self.is_float or (self.bits == 64 and not self.is_signed):
            raise ValueError(f"a signal of {self.bits} bits, float or unsigned, is no int64")
        bits = self._bits(words).astype(np.int64)
        if self.is_signed and self.bits < 64:
            sign = np.int64(1 << (self.bits - 1))
            bits = (bits ^ sign) - sign
        return bits

    def value(self, words: Words) -> FloatArray:
        """Return the signal (n,) in its unit."""
        bits = self._bits(words)
        if not self.is_float:
            raw = bits.astype(np.float64) if self.bits == 64 and not self.is_signed else self.raw(words)
        elif self.bits == 64:
            raw = bits.view(np.float64)
        else:
            size = {16: (np.uint16, np.float16), 32: (np.uint32, np.float32)}[self.bits]
            raw = bits.astype(size[0]).view(size[1])
        with np.errstate(invalid="ignore", over="ignore"):  # floats come as they were sent, nan and all
            value: FloatArray = np.asarray(raw, dtype=np.float64) * self.scale + self.offset
        return value

    def is_known(self, words: Words, *, by_j1939: bool = False) -> BoolArray:
        """Say which (n,) carry a value: not all ones, and within the range that the DBC states.

        ``by_j1939``: from FE00 (of 16 bits) on it is an error or not available (SAE J1939-71, 5.1.4).
        """
        value = self.value(words)
        step = abs(self.scale) / 2
        known = (value >= self.least - step) & (value <= self.most + step)
        if self.bits >= 8 and not (self.is_signed or self.is_float):
            first = 0xFE << (self.bits - 8) if by_j1939 else int(self.mask)
            known &= self._bits(words) < np.uint64(first)
        return known

    def put(self, words: Words, raw: IntArray) -> None:
        """Write integers ``raw`` (n,) into payloads whose bits there are zero."""
        word = words[int(self.is_big_endian)]
        word |= (raw.astype(np.int64).view(np.uint64) & self.mask) << np.uint64(self.shift)

    def _bits(self, words: Words) -> NDArray[np.uint64]:
        bits: NDArray[np.uint64] = (words[int(self.is_big_endian)] >> np.uint64(self.shift)) & self.mask
        return bits


def words_of(payloads: NDArray[np.uint8]) -> Words:
    """Return payloads (n, 8), padded with zeros, as 64-bit words."""
    whole = np.ascontiguousarray(payloads)
    return whole.view("<u8")[:, 0].astype(np.uint64), whole.view(">u8")[:, 0].astype(np.uint64)


def payloads_of(words: Words) -> NDArray[np.uint8]:
    """Return the payloads (n, 8) whose little-endian and big-endian signals were put into ``words``."""
    little, big = words
    octets: NDArray[np.uint8] = little.astype("<u8").view(np.uint8) | big.astype(">u8").view(np.uint8)
    return octets.reshape(-1, 8)


_LINE_NUMBER = re.compile(r"line (\d+)")
CLASSIC = 8  # bytes of a CAN 2.0 payload


def load_dbc(path: str) -> Database:
    """Return the database of a DBC in UTF-8 or ISO-8859-1; raise `BadCanFile` naming its line."""
    text = text_of(path)
    try:
        database = cantools.database.load_string(text, database_format="dbc")
    except Exception as error:  # the edge to a library whose parser raises what it likes
        found = " ".join(str(error).removeprefix("DBC: ").strip('"').split())
        line = _LINE_NUMBER.search(found)
        raise BadCanFile(path, int(line[1]) if line else None, found, "a DBC without errors") from error
    if not isinstance(database, Database):
        raise BadCanFile(path, None, "no CAN database", "a DBC")
    return database


def text_of(path: str) -> str:
    """Return a file's text, in UTF-8 or ISO-8859-1; raise `BadCanFile` where it cannot be read."""
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise BadCanFile(path, None, error.strerror or str(error), "a readable file") from error
    return decoded_text(content)


def identifier_of(message: Message) -> int:
    """Return a message's identifier with the flag of a 29-bit one."""
    return int(message.frame_id) | (EXTENDED if message.is_extended_frame else 0)


def field_of(path: str, message: Message, name: str) -> SignalField:
    """Return where one signal of a message stands; raise `BadCanFile` if it has none such, or none we can read."""
    signals = {signal.name: signal for signal in message.signals}
    if name not in signals:
        raise BadCanFile(path, None, f"no signal {name!r} in {message.name}", f"one of {', '.join(signals)}")
    signal = signals[name]
    if signal.multiplexer_ids or message.length > CLASSIC:
        kind = "is multiplexed" if signal.multiplexer_ids else f"is in a frame of {message.length} bytes"
        raise BadCanFile(path, None, f"{message.name}.{name} {kind}", "a plain signal of a frame of up to 8 bytes")
    least, most = signal.minimum, signal.maximum
    if least is None or most is None or most <= least:  # [0|0] is how a DBC says nothing
        least, most = -np.inf, np.inf
    return SignalField(
        start=signal.start,
        bits=signal.length,
        is_big_endian=signal.byte_order == "big_endian",
        is_signed=signal.is_signed,
        is_float=signal.is_float,
        scale=float(signal.scale),
        offset=float(signal.offset),
        unit=signal.unit or "",
        least=float(least),
        most=float(most),
    )
