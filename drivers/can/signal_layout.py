"""Signals out of many payloads at once, by the place that a DBC gives them.

A DBC counts a little-endian (Intel) signal's start from its lowest bit, a big-endian (Motorola) one's from its
highest, bit 0 being the lowest of byte 0. Read as one 64-bit word in the same byte order, either is a run of bits.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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
        """Say which (n,) tell a value: not all ones, and within the range that the DBC states.

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
