"""Whether signed integers were printed as unsigned ones: two's complement that nobody applied.

A channel near zero then jumps between the two ends of the range. A counter that wraps jumps in one direction
only, and fills the range between.
"""

import numpy as np

from procedures.arrays import FloatArray

WIDTHS = (12, 14, 16, 18, 20, 24, 32)  # bits of converters and registers
MIN_JUMPS = 2  # in each direction: fewer may be damaged rows
MAX_BETWEEN = 0.01  # share of samples in the middle half of the range


def unsigned_bits(values: FloatArray) -> int | None:
    """Return how many bits the signed integers had that ``values`` (n,) shows as unsigned ones; None of others."""
    known = values[np.isfinite(values)]
    if len(known) < 2 or known.min() < 0 or not (known == np.rint(known)).all():
        return None
    largest = float(known.max())
    bits = next((width for width in WIDTHS if largest < 2.0**width), None)
    if bits is None or largest < 0.75 * 2.0**bits:
        return None
    jumps = np.diff(known) / 2.0**bits
    if min(int((jumps > 0.5).sum()), int((jumps < -0.5).sum())) < MIN_JUMPS:
        return None
    between = np.mean((known > 0.25 * 2.0**bits) & (known < 0.75 * 2.0**bits))
    return bits if between < MAX_BETWEEN else None


def signed(values: FloatArray, bits: int) -> FloatArray:
    """Return ``values`` (n, ...) with two's complement of ``bits`` applied."""
    return np.where(values >= 2.0 ** (bits - 1), values - 2.0**bits, values)
