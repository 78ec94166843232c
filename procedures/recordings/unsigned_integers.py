"""Whether signed integers were printed as unsigned ones: two's complement that nobody applied.

A channel near zero then jumps between the two ends of the range. A counter that wraps jumps in one direction
only, and fills the range between.
"""

import numpy as np

from procedures.arrays import FloatArray

MIN_BITS, MAX_BITS = 8, 32  # of converters and registers
MIN_JUMPS = 2  # in each direction: fewer may be damaged rows
MAX_BETWEEN = 0.01  # share of samples in the middle half of the range
# Of the range, about zero, where no value lies: a speed that steps from 0 to 250, 500, ... deg/s leaves 0.02 free
MAX_SEAM = 0.01


def width(largest: float) -> int | None:
    """Return how many bits an unsigned integer needs; None of fewer or more than a register has."""
    bits = int(largest).bit_length() if 0 <= largest < 2.0**MAX_BITS else 0
    return bits if bits >= MIN_BITS else None


def unsigned_bits(values: FloatArray) -> int | None:
    """Return the bits of the signed integers that ``values`` (n,) [counts] shows as unsigned; None of others."""
    known = values[np.isfinite(values)]
    if len(known) < 2 or known.min() < 0 or not (known == np.rint(known)).all():
        return None
    largest = float(known.max())
    bits = width(largest)
    if bits is None or largest < 0.75 * 2.0**bits:
        return None
    is_negative = known >= 2.0 ** (bits - 1)
    seam = float(known.min()) + 2.0**bits - largest
    if seam > max(
        MAX_SEAM * 2.0**bits, *(np.ptp(known[side]) for side in (is_negative, ~is_negative) if side.any())
    ):
        return None
    jumps = np.diff(known) / 2.0**bits
    if min(int((jumps > 0.5).sum()), int((jumps < -0.5).sum())) < MIN_JUMPS:
        return None
    between = np.mean((known > 0.25 * 2.0**bits) & (known < 0.75 * 2.0**bits))
    return bits if between < MAX_BETWEEN else None


def signed(values: FloatArray, bits: int) -> FloatArray:
    """Return ``values`` (n, ...) [counts] with two's complement of ``bits`` applied."""
    return np.where(values >= 2.0 ** (bits - 1), values - 2.0**bits, values)
