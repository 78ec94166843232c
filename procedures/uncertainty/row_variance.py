"""The variance of every whitened row of a fit, split by source: noise, quantisation and others.

White noise leaves ``noise^2 / T`` of a dwell's rate: the counting noise; the rest of its variance is
quantisation. Of n samples the noise s [counts per sqrt(sample)] is seen n / tau times, ``tau = s^(-2/3)`` (1
where s > 1): there the remainders nearest to the interval's ends place the output as well as the noise moves it.
Every other look is independent. Simulated campaigns scatter as with 110, 38 and 257 degrees of freedom, where
this says 104, 48 and 200.
"""

from collections.abc import Sequence

import numpy as np

from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import CampaignFits
from procedures.counts.sample_records import CountSeries, Series
from procedures.frames import AXES
from procedures.free_positions.gyroscopes_from_moves import MovesAndRests, MovesFit, moves_and_rests
from procedures.twelve_positions.accelerometer_fit import RestFit, TriadFit
from procedures.twelve_positions.bench_parameters import BenchParameters
from procedures.twelve_positions.gyroscope_fit import GyroscopeFit
from procedures.twelve_positions.gyroscope_model import MovesSeen
from procedures.uncertainty import sources
from procedures.uncertainty.sources import Shares, SourceCell, added_shares

# Of the blocks: degrees of freedom of their Allan variance, white noise (NIST SP 1065, 5.4)
ALLAN_DOF_SHARE = 2 / 3
DWELL_BLOCKS = 128  # of a dwell, as `procedures.counts.dwell_means` has them at the least


def white_variance(noise: FloatArray, seconds: FloatArray, variance: FloatArray) -> FloatArray:
    """Return the part (n, 3) of a variance of mean rates that white noise makes up.

    Parameters
    ----------
    noise : (3,) or (n, 3) [output/sqrt(s)]
    seconds : (n,), that the means are over
    variance : (n, 3) [(output/s)^2]
    """
    return np.minimum(noise**2 / seconds[:, None], variance)


def durations_s(series: Sequence[Series]) -> FloatArray:
    """Return how long each of n recordings lasts (n,) [s], gaps left out."""
    return np.array([len(one) * one.period for one in series], dtype=np.float64)


def noise_dof(series: Sequence[Series], noise: FloatArray) -> FloatArray:
    """Return the degrees of freedom (3,) of a noise (3,) [output/sqrt(s)] from all of ``series`` together."""
    looks = np.zeros(3)
    for one in series:
        if isinstance(one, CountSeries):
            s = np.maximum(noise * np.sqrt(one.period), np.finfo(float).tiny)
            looks += len(one) / 2 / np.maximum(s ** (-2 / 3), 1.0)
        else:
            looks += ALLAN_DOF_SHARE * min(len(one), DWELL_BLOCKS)
    return np.maximum(looks - 1, 1.0)


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
    origin is the other fit (`procedures.uncertainty.budget`).
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
    """Return the degrees of freedom of a variance ``excess`` found beyond ``expected``, both of the same shape.

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
    is_tilted = np.array([tilt is not None and tilt.is_off for tilt in gyroscope.tilts or [None] * len(turns)])[
        :, None
    ]
    dof = noise_dof([dwell.series for _, dwell in seen.dwells], seen.noise)
    parts = by_axis(sources.COUNTING, "gyroscope", white, dof)
    parts |= by_axis(sources.QUANTISATION, "gyroscope", std**2 - white)
    parts |= {
        excess_cell(joint, "gyroscope"): excess,
        SourceCell(sources.WARM_UP, "gyroscope"): np.where(is_tilted, 0.0, np.maximum(drift, 0.0)),
    }
    if is_tilted.any():  # far beyond any drift
        parts[SourceCell(sources.SEAT, "turns")] = np.where(is_tilted, np.maximum(drift, 0.0), 0.0)
    return {cell: padded(part / gyroscope.turn_sigma**2, first, n) for cell, part in parts.items()}


def _move_shares(moves: MovesSeen, joint: TriadFit, n: int) -> Shares:
    """Split the moves' rotations: noise over their time, rounding, coning, bias instability."""
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
    tilt = np.full(len(moves.sigma), 2 * joint.rests.excess**2)
    free = float(np.sum(1 - moves.fit.leverage[: moves.error.size]))
    parts = {
        SourceCell(sources.COUNTING, "moves", float(dof.sum())): noise - tilt,
        SourceCell(sources.REST_SCATTER, "up vectors"): tilt,
        SourceCell(sources.MOVE_SCATTER, "", scatter_dof(free, noise, own)): own,
    }
    return {cell: np.repeat(part / moves.sigma**2, 2) for cell, part in parts.items()}


def _rest_parts(moves: MovesFit, seen: MovesAndRests) -> tuple[Shares, SourceCell]:
    """Split the rests' rows (r, 3): noise, quantisation, and bias instability, whose cell is returned too."""
    instability = np.broadcast_to((moves.scatter[1] * np.linalg.norm(moves.K, axis=1)) ** 2, seen.std.shape)
    white = white_variance(seen.noise, durations_s(seen.rests), seen.std**2)
    rows = slice(moves.error.size, moves.error.size + seen.rate.size)
    free = float(np.sum(1 - moves.fit.leverage[rows]))
    scatter = SourceCell(sources.INSTABILITY, "gyroscope", scatter_dof(free, seen.std**2, instability))
    parts = by_axis(sources.COUNTING, "gyroscope", white, noise_dof(seen.rests, seen.noise))
    parts |= by_axis(sources.QUANTISATION, "gyroscope", seen.std**2 - white) | {scatter: instability}
    return {cell: part / (seen.std**2 + instability) for cell, part in parts.items()}, scatter
