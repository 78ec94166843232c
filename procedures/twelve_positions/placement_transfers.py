"""Transfers by hand between placements: the integrated rotation must carry one placement into the next.

    R = C_b1n rotation(-Omega_n T) C_b0n',    R by the gyroscopes as in `transfer_rotation.py`

C_b0n and C_b1n are the cube's attitudes before and after, by slab, faces, headings and seats, Omega_n the Earth's
rate, T the time of the move. A flip by 180 deg measures the scale factor as half a turn does; moves between faces
measure their perpendicularity. Headings and seats are parameters that neighbouring moves share; the
accelerometers measure a seat to 0.1 ug but for the mean of its face. A move too fast for its sample rate is known
less well.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.campaign.campaign import Campaign, MoveRecord
from procedures.campaign.observations import TriadDwells, channel
from procedures.counts.sample_records import Series
from procedures.errors import MoveContradicts
from procedures.frames import rotation, rotation_vector
from procedures.positions import cross_axes, face_normal, face_of
from procedures.statistics.least_squares import Fit, joined_rows
from procedures.twelve_positions.accelerometer_fit import (
    TURN_ON_STEP_STD_G,
    TriadFit,
    fit_with_turn_ons,
    gravity_n,
)
from procedures.twelve_positions.transfer_rotation import AXIS_SIGNS_TRIED, FinerMoves, finer_moves, move_rotations
from procedures.units import RAD_PER_ARCSEC

ANGLES_TRIED = np.exp(np.arange(-0.5, 0.5, 0.05))  # of all moves together, relative to the shortest ways
MAX_GUESS_ERROR_RAD = 0.5  # rad above which no scale factor tried fits, or a move has a wrong label
MAX_DISAGREEMENT_RAD = float(np.radians(5))  # rad between a move and its placements: one label is wrong
MIN_SINGULAR_VALUE = 1e-6  # relative: what neither moves nor dwells show stays as it was
GUESS_STEPS = 6  # of Gauss and Newton, to where a move's rotation is linear in K and b
GUESSED = 1e-6  # of what such a placement may be off by, in its sigmas: the next step is its square
NOMINAL_STD_RAD = 2e-3  # rad, 1 sigma of a placement on a nominal bench


@dataclass(frozen=True, slots=True, eq=False)
class PlacementTransfers:
    """The m moves that are used: what they show, ``finer``, and where (m,) ``before`` and ``after`` they stood.

    Both number the placements, dwells first. ``from_turn`` (m,) is the turn at whose end a move begins, else -1.
    ``C_sb`` (m, 3, 3) takes the cube's axes to the IMU's; ``earth`` (m, 3) [rad/s] is the Earth's rate,
    East-North-Up. ``left_out`` says of which moves no use is made, and why.
    """

    records: tuple[MoveRecord, ...]
    campaign: IntArray
    finer: FinerMoves
    before: IntArray
    after: IntArray
    from_turn: IntArray
    C_sb: FloatArray
    earth: FloatArray
    left_out: tuple[str, ...] = ()

    def carried(self, attitudes: FloatArray, ends: FloatArray) -> FloatArray:
        """Return what the rotations (..., m, 3, 3) must be, in the IMU's axes.

        Parameters
        ----------
        attitudes : (..., n, 3, 3), East-North-Up to the cube, of every placement
        ends : (..., t, 3, 3), the same at the end of every turn
        """
        begin, turned = attitudes[..., self.before, :, :], self.from_turn >= 0
        begin[..., turned, :, :] = ends[..., self.from_turn[turned], :, :]
        after = attitudes[..., self.after, :, :]
        return carried_rotations(self.C_sb, begin, after, self.earth, self.finer.seconds)


def carried_rotations(
    C_sb: FloatArray, before: FloatArray, after: FloatArray, earth: FloatArray, seconds: FloatArray
) -> FloatArray:
    """Return what the rotations (..., m, 3, 3) of moves must be, in the IMU's axes.

    Parameters
    ----------
    C_sb : (m, 3, 3), takes the cube's axes to the IMU's
    before, after : (..., m, 3, 3), East-North-Up to the cube
    earth : (m, 3) [rad/s], the Earth's rate, East-North-Up
    seconds : (m,), how long each took
    """
    turned = after @ rotation(-earth * seconds[:, None]) @ np.swapaxes(before, -1, -2)
    carried: FloatArray = C_sb @ turned @ np.swapaxes(C_sb, 1, 2)
    return carried


def placement_transfers(
    campaigns: Sequence[Campaign], steps: Sequence[tuple[int, str]], dwells: int, earth: Sequence[FloatArray]
) -> PlacementTransfers | None:
    """Collect the moves between the placements ``steps`` (campaign, step's name), of which ``dwells`` are dwells.

    ``earth`` (3,) [rad/s] is of each campaign. Moves with lost samples or across a switching off are left out, and
    those without gyroscopes or whose end is no placement that is used; None if none stays.
    """
    place: Mapping[tuple[int, str], int] = {step: i for i, step in enumerate(steps)}
    used, ends, left_out = list[tuple[int, MoveRecord]](), list[tuple[int, int]](), list[str]()
    for number, campaign in enumerate(campaigns):
        turn_on = {dwell.name: dwell.turn_on for dwell in campaign.dwells}
        turn_on |= {turn.name: turn.turn_on for turn in campaign.turns}
        for move in campaign.moves:
            before, after = place.get((number, move.before)), place.get((number, move.after))
            if channel(move.series, "gyroscope") is None:
                left_out.append(f"{move.name} not used: it has no gyroscopes")
            elif before is None or after is None:
                left_out.append(f"{move.name} not used: {move.before} or {move.after} is not used")
            elif len(move.series.starts) > 1:
                left_out.append(f"{move.name} not used: samples were lost while the cube was moved")
            elif turn_on[move.before] != turn_on[move.after]:
                left_out.append(f"{move.name} not used: the unit was switched off between its ends")
            else:
                used.append((number, move))
                ends.append((before, after))
    if not used:
        return None
    numbers, records = [number for number, _ in used], tuple(move for _, move in used)
    begin, end = np.array(ends).T
    return PlacementTransfers(
        records, np.array(numbers), finer_moves([move.series for move in records]), begin, end,
        np.where(begin >= dwells, begin - dwells, -1), np.array([campaigns[n].fixture.C_sb for n in numbers]),
        np.array([earth[n] for n in numbers]), tuple(left_out),
    )  # fmt: skip


class MovesModel:
    """The moves' rows about K (9) [output/deg] and b (3) [output/s] in ``x0`` (12,): three errors a move.

    ``noise`` (3,) is the gyroscopes' white noise [output/sqrt(s)].
    """

    def __init__(self, moves: PlacementTransfers, x0: FloatArray, noise: FloatArray) -> None:
        self.moves, self.x0, self.noise = moves, x0.copy(), noise
        K, b = x0[:9].reshape(3, 3), x0[9:]
        seen = moves.finer.integrate(K, b)
        off = np.array([np.zeros(3) if record.off is None else record.off for record in moves.records])
        self.seen = replace(seen, rotation=rotation(off) @ seen.rotation)

    @cached_property
    def variance(self) -> FloatArray:
        """The variance (m, 3) [rad2] of noise, rounding and coning; no guess asks for it."""
        return self.moves.finer.variances(self.seen.squares, self.x0[:9].reshape(3, 3), self.x0[9:], self.noise)

    def errors(self, x: FloatArray, carried: FloatArray, bias: FloatArray | None = None) -> FloatArray:
        """Return (..., m, 3) [rad] by which ``carried`` is off what the gyroscopes say with K and b.

        Parameters
        ----------
        x : (..., 12), K and b
        carried : (..., m, 3, 3), the moves by the placements, IMU axes
        bias : (..., m, 3) [output/s], by how much a move's bias differs from b
        """
        change = (self.seen.sensitivity @ (x - self.x0)[..., None, :, None])[..., 0]
        if bias is not None:
            change += (self.seen.sensitivity[:, :, 9:] @ bias[..., None])[..., 0]
        return rotation_vector(carried @ np.swapaxes(rotation(-change) @ self.seen.rotation, -1, -2))


def first_guess(
    moves: PlacementTransfers, carried: FloatArray, u: FloatArray, seen: TriadDwells
) -> tuple[FloatArray, FloatArray] | None:
    """Return K (3, 3) [output/deg] and b (3,) [output/s] by moves and dwells on a nominal bench, or None.

    ``carried`` (m, 3, 3) are the nominal rotations, ``u`` (n, 3) [deg/s] the Earth's rate in every dwell.
    """
    x = _tried(moves, carried, np.median(seen.rate, axis=0))
    if x is None:
        return None
    n, std = len(u), seen.std.ravel()
    rest = np.hstack((np.einsum("qp,nj->nqpj", np.eye(3), u).reshape(3 * n, 9), np.tile(np.eye(3), (n, 1))))
    for _ in range(GUESS_STEPS):
        model = MovesModel(moves, x, seen.noise)
        error = model.errors(x, carried)
        fits = np.repeat(np.linalg.norm(error, axis=1) < MAX_GUESS_ERROR_RAD, 3)
        A = np.vstack((model.seen.sensitivity.reshape(-1, 12)[fits] / NOMINAL_STD_RAD, rest / std[:, None]))
        left = (seen.rate.ravel() - rest @ x) / std
        y = np.concatenate((-error.ravel()[fits] / NOMINAL_STD_RAD, left))
        size = np.linalg.norm(A, axis=0)
        step, *_ = np.linalg.lstsq(A / size, y, rcond=MIN_SINGULAR_VALUE)
        x = x + step / size
        if np.abs(step).max() < GUESSED:
            break
    return x[:9].reshape(3, 3), x[9:]


def refuse_contradicting(model: MovesModel, carried: FloatArray) -> None:
    """Raise `MoveContradicts` where a move does not do what its placements say, ``carried`` (m, 3, 3)."""
    error = np.linalg.norm(model.errors(model.x0, carried), axis=1)
    if len(error) and error.max() > MAX_DISAGREEMENT_RAD:
        worst = model.moves.records[int(np.argmax(error))]
        raise MoveContradicts(worst.name, worst.before, worst.after, float(np.degrees(error.max())))


def _tried(moves: PlacementTransfers, carried: FloatArray, b: FloatArray) -> FloatArray | None:
    """Return the best K (9) of one scale factor for all axes, each forward or backward, with b (3)."""
    shortest = np.linalg.norm(rotation_vector(carried), axis=1)
    samples = moves.finer.coarse
    turned = np.linalg.norm(((samples.output - b) * samples.real[..., None]).sum(axis=1), axis=1) * samples.period
    k = float(np.median(turned / np.maximum(np.degrees(shortest), 1.0)))
    best, found = MAX_GUESS_ERROR_RAD, None
    for signs in AXIS_SIGNS_TRIED:
        for angle in ANGLES_TRIED:
            K = np.diag(signs) * k / angle
            error = rotation_vector(carried @ np.swapaxes(move_rotations(samples, K, b), 1, 2))
            usual = float(np.median(np.linalg.norm(error, axis=1)))  # one wrong label must not spoil it
            if usual < best:
                best, found = usual, np.concatenate((K.ravel(), b))
        if found is not None:
            break
    return found


MAX_CONING_RAD = 2 * RAD_PER_ARCSEC  # rad, 1 sigma: as much as two seats leave open
ORDER = 4  # of the error, in what a sample turns
OF_EACH = (
    "campaign",
    "before",
    "after",
    "from_turn",
    "C_sb",
    "earth",
)  # arrays of `PlacementTransfers`, a row a move


def coning_of(series: Series, K: FloatArray, b: FloatArray) -> float:
    """Return 1 sigma [rad] of what coning leaves open of a move without gaps.

    ``K`` (3, 3) [output/deg] and ``b`` (3,) [output/s] are the gyroscopes', roughly.
    """
    return float(finer_moves([series]).coning(K, b)[0])


def long_enough_s(coning: float, seconds: float) -> float:
    """Return in how many seconds a move that took ``seconds`` and left ``coning`` [rad] would have been good."""
    return float(seconds * (coning / MAX_CONING_RAD) ** (1 / ORDER))


def without_fast(moves: PlacementTransfers, K: FloatArray, b: FloatArray) -> PlacementTransfers | None:
    """Return the moves but for those that were too fast, which are reported; None if none stays.

    ``K`` (3, 3) [output/deg] and ``b`` (3,) [output/s] are the gyroscopes', roughly.
    """
    coning = moves.finer.coning(K, b)
    kept = coning <= MAX_CONING_RAD
    if kept.all():
        return moves
    fast = [
        f"{moves.records[i].name} not used: moved too fast, {coning[i] / RAD_PER_ARCSEC:.0f} arcsec of coning"
        for i in np.flatnonzero(~kept)
    ]
    records = tuple(each for each, is_kept in zip(moves.records, kept, strict=True) if is_kept)
    if not records:
        return None
    kept_arrays = {name: getattr(moves, name)[kept] for name in OF_EACH}
    finer = finer_moves([each.series for each in records])
    return replace(moves, records=records, finer=finer, left_out=(*moves.left_out, *fast), **kept_arrays)


SEATING_SCALE_RAD = 0.1  # rad, at which a seat bends the model


def seating_rotations(positions: Sequence[int]) -> FloatArray:
    """Return (n, 3, 2): takes a seat's two tilts [rad] to the rotation vector of the cube in a position 1..24."""
    rows = list[FloatArray]()
    for position in positions:
        face = face_of(position)
        rows.append(np.stack([np.cross(face_normal(face), np.eye(3)[k]) for k in cross_axes(face)], axis=1))
    return np.stack(rows)


def seated(accelerometer: TriadFit, seat: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return what the accelerometers say of bench and seats, (p + 2 n,) [rad], its covariance and its `gain`.

    ``accelerometer`` is their fit of n dwells, in which all seats are alike; ``seat`` (n,) [rad] is 1 sigma of a
    seat. The p parameters are those of the bench that belong to no single placement. Steps of the bias between
    turn-ons are free here too: those found while all seats were alike hold what a seat did to its turn-on.
    """
    bench, seen = accelerometer.bench, accelerometer.seen
    shared, n, size = 12 + bench.shared, len(seat), len(accelerometer.fit.x)
    prior, sigma = bench.priors(), accelerometer.sigma
    tilts = seating_rotations([at.position for at in bench.placements])
    spread = np.repeat(seat, 2)

    def residual(x: FloatArray, steps: FloatArray) -> FloatArray:
        at, K = x[..., 12:size], x[..., :9].reshape(*x.shape[:-1], 3, 3)
        turned = bench.attitudes(at, (tilts @ x[..., size:].reshape(*x.shape[:-1], n, 2, 1))[..., 0])
        up = np.stack(gravity_n(bench, at), axis=-2)[..., [place.campaign for place in bench.placements], :]
        u = (bench.C_sb @ turned @ up[..., None])[..., 0]
        off = (seen.rate - steps - u @ np.swapaxes(K, -1, -2) - x[..., None, 9:12]) / sigma
        return joined_rows(x, off, at @ prior.matrix.T - prior.mean, x[..., size:] / spread)

    start = np.concatenate((accelerometer.fit.x, np.zeros(2 * n)))
    scale = np.full(len(start), SEATING_SCALE_RAD)
    scale[:12] = np.max(np.abs(accelerometer.fit.x[:12]))
    turn_ons = [(number, dwell.turn_on) for number, dwell in seen.dwells]
    fit = fit_with_turn_ons(residual, start, scale, turn_ons, TURN_ON_STEP_STD_G * accelerometer.k).fit
    kept = np.r_[12:shared, size : len(start)]
    return fit.x[kept], fit.covariance[np.ix_(kept, kept)], gain(fit, sigma)[kept]


def gain(fit: Fit, sigma: FloatArray) -> FloatArray:
    """Return the change (p, 3 n) of a fit's parameters with the n rates that its first rows are of.

    ``sigma`` (n, 3) is 1 sigma of the rates [output/s].
    """
    change: FloatArray = -fit.covariance @ fit.jacobian[: sigma.size].T / sigma.ravel()
    return change
