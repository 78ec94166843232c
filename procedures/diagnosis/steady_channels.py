"""Channels that turn at a steady speed: what errs with their angle is a line in time, and the other way round.

A motor at constant speed makes ``k`` times its turns a second of everything that goes with its angle. A recording
in which the speed never changes cannot tell which of the two it is.
"""

import numpy as np

from procedures.arrays import FloatArray
from procedures.diagnosis.sample_blocks import SampleBlocks

TURNS = (1.0, 2 * np.pi, 360.0)  # one turn, in the units that an angle is told in
MAX_HARMONIC = 12
STEADY_SHARE = 0.02  # of its step from sample to sample, by which a steady angle's steps may differ
WITHIN_CYCLES = 1.0  # of a whole recording, within which two frequencies are one


def steady_channels(blocks: SampleBlocks, hertz: float) -> tuple[str, ...]:
    """Return the auxiliary channels whose angle goes round evenly, a whole share of ``hertz`` times a second."""
    return tuple(
        name
        for name, values in blocks.auxiliary.items()
        if all(any(_makes(value, turn, hertz * blocks.period) for turn in TURNS) for value in values)
    )


def _makes(values: FloatArray, turn: float, line: float) -> bool:
    """Say whether an angle (n,), of so much a ``turn``, makes a line of ``line`` cycles a sample."""
    steps = np.diff(values) / turn
    step = float(np.median(steps))
    off = np.abs(steps - step)
    off = np.minimum(off, np.abs(off - np.round(off)))  # a whole turn is where it wraps
    if not step or np.quantile(off, 0.99) > STEADY_SHARE * abs(step):
        return False
    harmonic = round(line / abs(step))
    return 1 <= harmonic <= MAX_HARMONIC and abs(line - harmonic * abs(step)) * len(values) < WITHIN_CYCLES
