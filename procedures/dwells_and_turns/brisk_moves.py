"""Moves too brisk for their sample rate: what the axis turned within the samples is not known well enough.

The hand's own rate falls with the time of a move and coning's error with the fourth power of it
(`procedures.dwells_and_turns.finer_moves`), which says how long a move had better last.
"""

from dataclasses import replace

import numpy as np

from procedures.arrays import FloatArray
from procedures.counts.sample_records import Series
from procedures.dwells_and_turns.finer_moves import finer_moves
from procedures.dwells_and_turns.placing_moves import PlacingMoves
from procedures.units import RAD_PER_ARCSEC

MAX_CONING_RAD = 2 * RAD_PER_ARCSEC  # rad, 1 sigma: as much as two seats leave open
ORDER = 4  # of the error, in what a sample turns
OF_EACH = ("campaign", "before", "after", "from_turn", "C_sb", "earth")  # arrays of `PlacingMoves`, a row a move


def coning_of(series: Series, K: FloatArray, b: FloatArray) -> float:
    """Return 1 sigma [rad] of what coning leaves open of a move without gaps.

    ``K`` (3, 3) [output/deg] and ``b`` (3,) [output/s] are the gyroscopes', roughly.
    """
    return float(finer_moves([series]).coning(K, b)[0])


def long_enough_s(coning: float, seconds: float) -> float:
    """Return in how many seconds a move that took ``seconds`` and left ``coning`` [rad] would have been good."""
    return float(seconds * (coning / MAX_CONING_RAD) ** (1 / ORDER))


def without_brisk(moves: PlacingMoves, K: FloatArray, b: FloatArray) -> PlacingMoves | None:
    """Return the moves but for those that were too brisk, which are said; None if none stays.

    ``K`` (3, 3) [output/deg] and ``b`` (3,) [output/s] are the gyroscopes', roughly.
    """
    coning = moves.finer.coning(K, b)
    kept = coning <= MAX_CONING_RAD
    if kept.all():
        return moves
    brisk = [
        f"{moves.records[i].name} not used: moved too fast, {coning[i] / RAD_PER_ARCSEC:.0f} arcsec of coning"
        for i in np.flatnonzero(~kept)
    ]
    records = tuple(each for each, is_kept in zip(moves.records, kept, strict=True) if is_kept)
    if not records:
        return None
    kept_arrays = {name: getattr(moves, name)[kept] for name in OF_EACH}
    finer = finer_moves([each.series for each in records])
    return replace(moves, records=records, finer=finer, left_out=(*moves.left_out, *brisk), **kept_arrays)
