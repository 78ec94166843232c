"""The variance of the rows of a fit of moves between rests, split by source."""

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.dwells_and_turns.twelve_position import TriadFit
from procedures.rests_and_moves.gyroscopes_from_moves import MovesAndRests, MovesFit, moves_and_rests
from procedures.uncertainty import sources
from procedures.uncertainty.noise_and_quantisation import durations_s, noise_dof, white_variance
from procedures.uncertainty.row_variance import by_axis, padded, scatter_dof
from procedures.uncertainty.sources import Shares, SourceCell, added_shares


def moves_shares(fits: CampaignFits) -> tuple[Shares, SourceCell]:
    """Split the rows (n,): moves, rests, the Earth's horizontal rate; and return the cell of bias instability.

    A move's noise is that of the up vectors at both its ends and of the gyroscopes on the way.
    """
    moves, joint = fits.moves, fits.accelerometer
    assert moves is not None
    assert joint is not None
    seen = moves_and_rests(fits.campaigns, fits.segmented, joint)
    assert seen is not None
    n = len(moves.fit.residual)
    at_rest, scatter = _rest_parts(moves, seen)
    first, last = moves.error.size, moves.error.size + seen.rate.size
    known = np.zeros(n)
    known[last:] = 1.0
    return added_shares(
        {
            cell: padded(part, 0, n)
            for cell, part in _move_parts(moves, joint, noise_dof(seen.rests, seen.noise)).items()
        },
        {cell: padded(part, first, n) for cell, part in at_rest.items()},
        {SourceCell(sources.HEADING, "of the Earth's rate"): known},
    ), scatter


def _move_parts(moves: MovesFit, joint: TriadFit, dof: FloatArray) -> Shares:
    """Split the moves' rows (m, 2): noise, the scatter of rests that the up vectors have, that of the moves."""
    assert joint.rests is not None
    noise, own = moves.sigma**2 - moves.scatter[0] ** 2, np.full(len(moves.sigma), moves.scatter[0] ** 2)
    lean = np.full(len(moves.sigma), 2 * joint.rests.excess**2)
    free = float(np.sum(1 - moves.fit.leverage[: moves.error.size]))
    parts = {
        SourceCell(sources.COUNTING, "moves", float(dof.sum())): noise - lean,
        SourceCell(sources.REST_SCATTER, "up vectors"): lean,
        SourceCell(sources.MOVE_SCATTER, "", scatter_dof(free, noise, own)): own,
    }
    return {cell: np.repeat(part / moves.sigma**2, 2) for cell, part in parts.items()}


def _rest_parts(moves: MovesFit, seen: MovesAndRests) -> tuple[Shares, SourceCell]:
    """Split the rests' rows (r, 3): noise, quantisation, and bias instability, whose cell is returned too."""
    wander = np.broadcast_to((moves.scatter[1] * np.linalg.norm(moves.K, axis=1)) ** 2, seen.std.shape)
    white = white_variance(seen.noise, durations_s(seen.rests), seen.std**2)
    rows = slice(moves.error.size, moves.error.size + seen.rate.size)
    free = float(np.sum(1 - moves.fit.leverage[rows]))
    scatter = SourceCell(sources.INSTABILITY, "gyroscope", scatter_dof(free, seen.std**2, wander))
    parts = by_axis(sources.COUNTING, "gyroscope", white, noise_dof(seen.rests, seen.noise))
    parts |= by_axis(sources.QUANTISATION, "gyroscope", seen.std**2 - white) | {scatter: wander}
    return {cell: part / (seen.std**2 + wander) for cell, part in parts.items()}, scatter
