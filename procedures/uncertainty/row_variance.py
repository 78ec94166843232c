"""The variance of every whitened row of a fit, one by construction, split by source."""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.dwells_and_turns.bench_parameters import BenchParameters
from procedures.dwells_and_turns.gyroscope_model import MovesSeen
from procedures.dwells_and_turns.gyroscopes_joint_fit import GyroscopeFit
from procedures.dwells_and_turns.twelve_position import RestFit, TriadFit
from procedures.frames import AXES
from procedures.uncertainty import sources
from procedures.uncertainty.noise_and_quantisation import durations_s, noise_dof, white_variance
from procedures.uncertainty.sources import Shares, SourceCell, added_shares


def joint_shares(joint: TriadFit, triad: str) -> Shares:
    """Split the rows (n,) of an accelerometers' fit: dwells, priors, what holds the frame, norms, ups."""
    n, rests = len(joint.fit.residual), joint.rests
    priors = range(3 * len(joint.seen.dwells), n if rests is None else rests.rows.start)
    parts = [dwell_shares(joint, triad, n), prior_shares(joint, priors)]
    if rests is not None:
        parts += [norm_shares(joint, rests, n), _of(sources.SLAB, range(rests.rows.stop, n), n)]
    return added_shares(*parts)


def gyroscope_shares(gyroscope: GyroscopeFit, tilts: bool) -> Shares:
    """Split the rows (n,) of the gyroscopes' fit: dwells, turns, priors, closures.

    ``tilts``: the bench's shared parameters come from the accelerometers. Those rows get no share here, their
    origin is the other fit (`procedures.uncertainty.triad_variance`).
    """
    joint, moves = gyroscope.joint, gyroscope.moves
    n, closures = len(joint.fit.residual), len(gyroscope.turns)
    first = 3 * (len(joint.seen.dwells) + closures) + (joint.bench.shared if tilts else 0)
    kinds = [*bench_sources(joint.bench), *[sources.CLOSURE] * closures]
    kinds += [sources.SEAT] * (len(joint.fit.x) - 12 - len(kinds))
    return added_shares(
        dwell_shares(joint, "gyroscope", n),
        _turn_shares(gyroscope, n),
        prior_shares(joint, range(first, moves.rows.start if moves else n - closures), kinds),
        _move_shares(moves, joint, n) if moves else {},
        _of(sources.CLOSURE, range(n - closures, n), n),
    )


def dwell_shares(joint: TriadFit, triad: str, n: int) -> Shares:
    """Split the rows of dwells, which come first of ``n``: noise, quantisation, scatter found and stated."""
    seen = joint.seen
    if not seen.dwells:
        return {}
    series = [dwell.series for _, dwell in seen.dwells]
    noise = np.array([[each.noise for each in row] for row in seen.estimates])
    white = white_variance(noise, durations_s(series), seen.std**2)
    scatter = np.broadcast_to(joint.excess**2, white.shape)
    parts = by_axis(sources.COUNTING, triad, white, noise_dof(series, seen.noise))
    parts |= by_axis(sources.QUANTISATION, triad, seen.std**2 - white)
    parts |= {excess_cell(joint, triad): scatter, SourceCell(sources.WARM_UP, triad): joint.unsettled**2}
    return {cell: padded(part / joint.sigma**2, 0, n) for cell, part in parts.items()}


def excess_cell(joint: TriadFit, triad: str) -> SourceCell:
    """Return the cell of the bias instability that the dwells show; without dwells one that holds nothing."""
    if not joint.seen.dwells:
        return SourceCell(sources.INSTABILITY, triad)
    rows = slice(0, joint.seen.std.size)
    free = float(np.sum(1 - joint.fit.leverage[rows]))
    return SourceCell(sources.INSTABILITY, triad, scatter_dof(free, joint.expected**2, joint.excess**2))


def scatter_dof(free: float, expected: FloatArray, excess: FloatArray) -> float:
    """Return the degrees of freedom of a variance ``excess`` found beside ``expected``, both of the same shape.

    It is a difference, total less expected. The total has ``free``; of the difference, a share s of the total,
    ``free s^2`` remain. At least 1, below which Student's distribution is of no use.
    """
    return max(free * float(np.mean(excess / (expected + excess))) ** 2, 1.0)


def by_axis(
    source: str, of: str, variance: FloatArray, dof: FloatArray | None = None
) -> dict[SourceCell, FloatArray]:
    """Give every column of ``variance`` (n, 3) a cell of its own; ``dof`` (3,), infinite if None."""
    parts = dict[SourceCell, FloatArray]()
    for axis, letter in enumerate(AXES):
        alone = np.zeros(variance.shape)
        alone[:, axis] = variance[:, axis]
        parts[SourceCell(source, f"{of} {letter}", np.inf if dof is None else float(dof[axis]))] = alone
    return parts


def _turn_shares(gyroscope: GyroscopeFit, n: int) -> Shares:
    """Split the turns' totals: noise over their time, remainders of counts, scatter and drift of the bias."""
    joint, turns = gyroscope.joint, gyroscope.turns
    first, seen = 3 * len(joint.seen.dwells), joint.seen
    seconds = np.array([turn.seconds for turn in turns])[:, None]
    std = np.array([turn.std for turn in turns]).reshape(-1, 3)
    white = np.minimum(seen.noise**2 * seconds, std**2)
    excess = (joint.excess * seconds) ** 2
    drift = gyroscope.turn_sigma**2 - std**2 - excess
    leant = np.array([lean is not None and lean.is_off for lean in gyroscope.leans or [None] * len(turns)])[
        :, None
    ]
    dof = noise_dof([dwell.series for _, dwell in seen.dwells], seen.noise)
    parts = by_axis(sources.COUNTING, "gyroscope", white, dof)
    parts |= by_axis(sources.QUANTISATION, "gyroscope", std**2 - white)
    parts |= {
        excess_cell(joint, "gyroscope"): excess,
        SourceCell(sources.WARM_UP, "gyroscope"): np.where(leant, 0.0, np.maximum(drift, 0.0)),
    }
    if leant.any():  # far beyond any drift
        parts[SourceCell(sources.SEAT, "turns")] = np.where(leant, np.maximum(drift, 0.0), 0.0)
    return {cell: padded(part / gyroscope.turn_sigma**2, first, n) for cell, part in parts.items()}


def _move_shares(moves: MovesSeen, joint: TriadFit, n: int) -> Shares:
    """Split the moves' rotations: noise over their time, rounding, coning, wander of the bias."""
    share = np.repeat(moves.variance / moves.sigma[:, None] ** 2, 3, axis=0)
    dof = float(np.mean(noise_dof([dwell.series for _, dwell in joint.seen.dwells], joint.seen.noise)))
    cells = (
        SourceCell(sources.COUNTING, "gyroscope moves", dof), SourceCell(sources.QUANTISATION, "gyroscope moves"),
        SourceCell(sources.CONING), excess_cell(joint, "gyroscope"),
    )  # fmt: skip
    return {cell: padded(part, moves.rows.start, n) for cell, part in zip(cells, share.T, strict=True)}


def prior_shares(joint: TriadFit, rows: Sequence[int], kinds: Sequence[str] = ()) -> Shares:
    """Name every row of prior knowledge by the parameters that it speaks of: the bench's, or ``kinds``."""
    n, kinds = len(joint.fit.residual), kinds or bench_sources(joint.bench)
    found = dict[SourceCell, FloatArray]()
    for row in rows:
        about = np.abs(joint.fit.jacobian[row])
        strongest = int(np.argmax(about[12 : 12 + len(kinds)])) if len(kinds) else 0
        is_frame = about[:12].max() > 0
        cell = SourceCell(sources.FRAME if is_frame else kinds[strongest])
        found.setdefault(cell, np.zeros(n))[row] = 1.0
    return found


def bench_sources(bench: BenchParameters) -> list[str]:
    """Return the source that each of a bench's parameters stands for."""
    found = [sources.SLAB] * (2 * len(bench.campaigns)) + [sources.GRAVITY] * len(bench.sites)
    return found + [sources.CUBE] * (12 * bench.cubes) + [sources.HEADING] * len(bench.placements)


def norm_shares(joint: TriadFit, rests: RestFit, n: int) -> Shares:
    """Split the norms of rests: noise of each sensor along the vertical, what E leaves open, scatter found."""
    seen, series = rests.rests, [rest.series for _, rest in rests.rests.rests]
    white = white_variance(np.broadcast_to(seen.noise, seen.std.shape), durations_s(series), seen.std**2)
    along = np.linalg.solve(joint.K.T, rests.up.T).T ** 2
    on_face = np.array([rest.up is not None for _, rest in seen.rests])
    counted = np.sum(along * seen.std**2, axis=1)
    wide = np.where(on_face, np.maximum(rests.noise**2 - counted, 0.0), 0.0)
    scale = ((rests.noise**2 - wide) / counted)[:, None]
    free = float(np.sum(1 - joint.fit.leverage[rests.rows]))
    dof = scatter_dof(free, rests.noise**2, np.full(len(wide), rests.excess**2))
    parts = {
        cell: part.sum(axis=1)
        for cell, part in (
            by_axis(sources.COUNTING, "accelerometer", along * white * scale, noise_dof(series, seen.noise))
            | by_axis(sources.QUANTISATION, "accelerometer", along * (seen.std**2 - white) * scale)
        ).items()
    }
    parts |= {SourceCell(sources.SECOND_ORDER): wide}
    parts |= {SourceCell(sources.REST_SCATTER, "accelerometer", dof): np.full(len(wide), rests.excess**2)}
    return {cell: padded(part / rests.sigma**2, rests.rows.start, n) for cell, part in parts.items()}


def _of(source: str, rows: range, n: int) -> Shares:
    share = np.zeros(n)
    share[rows.start : rows.stop] = 1.0
    return {SourceCell(source): share}


def padded(part: FloatArray, first: int, n: int) -> FloatArray:
    """Return zeros (n,) with ``part``, whatever its shape, from ``first`` on."""
    whole = np.zeros(n)
    whole[first : first + part.size] = part.ravel()
    return whole
