"""The residual of the gyroscopes' joint fit: dwells, turns, moves, and what is known before the first count."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from procedures.arrays import BoolArray, FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord
from procedures.campaign.observations import TriadDwells, TurnTotal
from procedures.frames import rotation
from procedures.geodesy import earth_rate_n
from procedures.positions import cross_axes, face_of
from procedures.statistics.least_squares import Fit, joined_rows
from procedures.twelve_positions.accelerometer_fit import TriadFit, TurnOnFit, fit_with_turn_ons
from procedures.twelve_positions.bench_parameters import BenchParameters, BenchPrior, Placement, cube_numbers
from procedures.twelve_positions.manual_rotations import RotationGeometry
from procedures.twelve_positions.placement_transfers import (
    MovesModel,
    PlacementTransfers,
    gain,
    seated,
    seating_rotations,
)
from procedures.twelve_positions.rotation_tilt import RotationTilt
from procedures.units import DEG_H_PER_DEG_S

# deg/s, 1 sigma of what a bias may step by as a unit is switched off and on
TURN_ON_STEP_STD_DEG_S = 30 / DEG_H_PER_DEG_S
TILT_FLOOR_RAD = 1e-12  # rad, of what the accelerometers did not leave open


@dataclass(frozen=True, slots=True, eq=False)
class MovesSeen:
    """The ``moves`` of a fit, and ``error`` (m, 3) [rad] by which each is off; ``rows`` are the fit's (3 m).

    ``variance`` (m, 4) [rad2] of a component is by white noise, rounding, coning and the bias instability.
    ``by_accelerometer`` (k, 3 n) is by how much the first k whitened rows of what is known change with the rates
    of the accelerometers' n dwells [s/output], from whose fit they are; no row where there is none.
    """

    moves: PlacementTransfers
    error: FloatArray
    variance: FloatArray
    rows: slice
    by_accelerometer: FloatArray

    @property
    def sigma(self) -> FloatArray:
        """1 sigma (m,) [rad] of each component."""
        total: FloatArray = np.sqrt(self.variance.sum(axis=1))
        return total


class GyroscopeModel:
    """Parameters: K (9), b (3), the bench's, a closure per turn [deg]; with moves a seat (2) per placement [rad].

    Rows are those of dwells (n, 3), turns (t, 3), the priors, moves (m, 3), and closures (t,).
    """

    def __init__(
        self, campaigns: Sequence[Campaign], seen: TriadDwells, turns: Sequence[TurnTotal],
        shapes: Sequence[RotationGeometry], accelerometer: TriadFit | None, moves: PlacementTransfers | None,
        tilts: Sequence[RotationTilt | None] = (),
    ) -> None:  # fmt: skip
        self.bench = gyroscope_bench(campaigns, seen, turns, moves is not None)
        self.seen, self.turns, self.moves = seen, turns, moves
        self.motion = np.stack([np.eye(3)] * len(seen.dwells) + [s.motion for s in shapes])
        self.angle = np.degrees([s.angle for s in shapes])
        self.closure = np.degrees([s.closure_std for s in shapes])
        self.earth = [np.degrees(earth_rate_n(c.site.latitude)) for c in campaigns]
        # (m, 1): a dwell is known by its rate, a turn by its total
        self.seconds = np.array([1.0] * len(seen.dwells) + [turn.seconds for turn in turns])[:, None]
        of = self.bench.placements
        sigmas = [campaigns[at.campaign].sigma for at in of]
        self.unsettled_deg_s = np.degrees([each.unsettled_gyro for each in sigmas])
        seat = np.array([each.seat for each in sigmas]) if moves else np.zeros(0)
        self._tilts = seating_rotations([at.position for at in self.bench.placements])
        self._tilt = np.zeros((len(of), 2))  # rad, of cubes that tilted as they were turned
        self.tilt_std = np.zeros((len(of), 3))  # deg, 1 sigma of a turn by its axis, IMU axes
        for i, tilt in enumerate(tilts, start=len(seen.dwells)):
            if tilt is not None and tilt.is_off:
                seat[i : i + 1] = tilt.std.max()
                self._tilt[i] = tilt.mean
                across = np.abs(self.bench.C_sb[i][:, list(cross_axes(face_of(of[i].position)))])
                self.tilt_std[i] = abs(self.angle[i - len(seen.dwells)]) * (across @ tilt.axis_std)
        self.prior = _prior(self.bench, seen.dwells, accelerometer, seat)
        self._total = np.array([t.total for t in turns]).reshape(-1, 3)
        self._total_std = np.array([t.std for t in turns]).reshape(-1, 3)

    @property
    def size(self) -> int:
        """Number of parameters."""
        return 12 + self.bench.size + len(self.turns) + int(self.prior.seats.shape[1])

    def output(self, x: FloatArray) -> FloatArray:
        """Modelled rate of every dwell, then total of every turn, (..., n + t, 3), by parameters x (..., p)."""
        n, closures = len(self.seen.dwells), 12 + self.bench.size
        bench, closed = x[..., 12:closures], x[..., closures : closures + len(self.turns)]
        u = self.bench.seen(bench, self.earth, self.motion)
        normal = self.bench.to_cube(bench)[..., n:, :, 2]
        if self.moves is not None or self._tilt.any():
            # a cube tilts by its seat while it is turned, and turns about the slab's normal
            normal = (rotation(self._seats(x, 0.5)[..., n:, :]) @ normal[..., None])[..., 0]
        u[..., n:, :] += (self.angle + closed)[..., None] * normal
        K, b = x[..., :9].reshape(*x.shape[:-1], 3, 3), x[..., None, 9:12]
        return (self.bench.C_sb @ u[..., None])[..., 0] @ np.swapaxes(K, -1, -2) + self.seconds * b

    def carried(self, x: FloatArray) -> FloatArray:
        """Return the moves' rotations (..., m, 3, 3) by the placements, IMU axes; ``x`` (..., p) as in `fit`."""
        assert self.moves is not None
        n, closures = len(self.seen.dwells), 12 + self.bench.size
        bench = x[..., 12:closures]
        attitudes = self.bench.attitudes(bench, self._seats(x))
        closed = np.radians(x[..., closures : closures + len(self.turns)])
        slab = self.bench.to_cube(bench)[..., n:, :, :]
        turned = slab @ rotation(closed[..., None] * [0.0, 0.0, -1.0]) @ np.swapaxes(slab, -1, -2)
        return self.moves.carried(attitudes, turned @ attitudes[..., n:, :, :])

    def _seats(self, x: FloatArray, tilt: float = 1.0) -> FloatArray:
        """Return rotation vectors (..., m, 3) [rad] of placements' seats, with a share ``tilt`` of tilts."""
        seats = tilt * self._tilt
        if self.moves is not None:
            seats = seats + x[..., 12 + self.bench.size + len(self.turns) :].reshape(*x.shape[:-1], -1, 2)
        rotated: FloatArray = (self._tilts @ seats[..., None])[..., 0]
        return rotated

    def sigma(self, excess: FloatArray, k: FloatArray) -> FloatArray:
        """1 sigma (n + t, 3) of every dwell's rate and every turn's total; k, ``excess`` (3,) [output/s]."""
        std = np.vstack((self.seen.std, self._total_std))
        expected = np.hypot(std, self.unsettled(k) * self.seconds)
        total: FloatArray = np.sqrt(expected**2 + (excess * self.seconds) ** 2 + (k * self.tilt_std) ** 2)
        return total

    def unsettled(self, k: FloatArray) -> FloatArray:
        """1 sigma (n + t, 3) [output/s] that campaigns state of the bias from step to step, for k (3,)."""
        return np.outer(self.unsettled_deg_s, k)

    def fit(self, start: FloatArray, excess: FloatArray, k: FloatArray) -> TurnOnFit:
        """Minimise with a given scatter of the bias from step to step, turn-ons apart.

        Parameters
        ----------
        start : (p,), the parameters to begin with: K, b [output/s], bench [rad], closures [deg], seats [rad]
        excess : (3,), the scatter [output/s]
        k : (3,), scale factors [output/deg]
        """
        observed = np.vstack((self.seen.rate, self._total))
        sigma, size, turns = self.sigma(excess, k), self.bench.size, len(self.turns)
        model = MovesModel(self.moves, start[:12], self.seen.noise) if self.moves else None
        instability = self.instability(excess, k)
        turn_ons = [(number, dwell.turn_on) for number, dwell in self.seen.dwells]
        turn_ons += [(turn.campaign, turn.record.turn_on) for turn in self.turns]

        def residual(x: FloatArray, steps: FloatArray) -> FloatArray:
            rows = [(observed - steps * self.seconds - self.output(x)) / sigma]
            rows.append(x[..., 12 : 12 + size] @ self.prior.bench.matrix.T - self.prior.bench.mean)
            if model is not None and self.moves is not None:
                moved = np.sqrt(model.variance.sum(axis=1) + instability)
                bias = steps[..., self.moves.after, :]
                error = model.errors(x[..., :12], self.carried(x), bias)
                rows[-1] += x[..., 12 + size + turns :] @ self.prior.seats.T
                rows.append(error / moved[:, None])
            return joined_rows(x, *rows, x[..., 12 + size : 12 + size + turns] / self.closure)

        typical = np.max(np.abs(start[:9]))
        scale = np.concatenate(
            (
                np.full(9, typical),
                np.full(3, typical * 1e-2),
                np.full(size, 0.1),
                np.full(turns, 1.0),
                np.full(self.prior.seats.shape[1], 0.1),
            )
        )
        return fit_with_turn_ons(residual, start, scale, turn_ons, TURN_ON_STEP_STD_DEG_S * k)

    def instability(self, excess: FloatArray, k: FloatArray) -> FloatArray:
        """Return the variance (m,) [rad2] of the moves by the scatter ``excess`` (3,) [output/s] of the bias.

        ``k`` (3,) are the scale factors [output/deg].
        """
        seconds = self.moves.finer.seconds if self.moves else np.zeros(0)
        variance: FloatArray = np.mean((np.radians(excess / k)) ** 2) * seconds**2
        return variance

    def moved(self, found: TurnOnFit, excess: FloatArray, k: FloatArray) -> MovesSeen:
        """Return what is left of the moves; the fit's last rows but the closures are theirs.

        ``excess`` (3,) [output/s] is the scatter of the bias, ``k`` (3,) the scale factors [output/deg].
        """
        assert self.moves is not None
        fit = found.fit
        model = MovesModel(self.moves, fit.x[:12], self.seen.noise)
        end = len(fit.residual) - len(self.turns)
        return MovesSeen(
            self.moves,
            model.errors(fit.x[:12], self.carried(fit.x), found.steps[self.moves.after]),
            np.column_stack((model.variance, self.instability(excess, k))),
            slice(end - 3 * len(self.moves.records), end),
            self.prior.by_accelerometer,
        )

    def excess(self, fit: Fit) -> FloatArray:
        """Return the scatter (3,) of the bias from dwell to dwell beyond what is expected of it [output/s].

        One relative scatter for the triad: the dwells' weighted squares are brought to what the fit leaves free
        (the moment estimator of Mandel and Paule, Anal. Chem. 42, 1970).
        """
        n = len(self.seen.dwells)
        squares = (fit.residual[: 3 * n] ** 2).reshape(n, 3)
        free = (1 - fit.leverage[: 3 * n]).reshape(n, 3)
        k = np.linalg.norm(fit.x[:9].reshape(3, 3), axis=1)
        ratio = float(squares.sum() / free.sum())
        expected = np.hypot(self.seen.std, self.unsettled(k)[:n])
        scatter: FloatArray = k * np.median(expected / k) * np.sqrt(max(ratio - 1, 0.0))
        return scatter


def gyroscope_bench(
    campaigns: Sequence[Campaign], seen: TriadDwells, turns: Sequence[TurnTotal], skew_seen: bool
) -> BenchParameters:
    """Lay out the bench's parameters for dwells and turns; ``skew_seen``: moves show the cube's skew."""
    cubes = cube_numbers(campaigns)
    steps = [(n, d.position) for n, d in seen.dwells]
    steps += [(t.campaign, t.record.start_position) for t in turns]
    placements = tuple(Placement(n, int(cubes[n]), p, campaigns[n].sigma.heading) for n, p in steps)
    return BenchParameters(placements, tuple(campaigns), int(cubes.max()) + 1, skew_seen)


@dataclass(frozen=True, slots=True, eq=False)
class _Prior:
    """Rows of what is known of bench and seats: ``bench.matrix @ x + seats @ s - bench.mean``; seats (k, 2 m).

    ``by_accelerometer`` (j, 3 n) is the change of the first j with the rates of the accelerometers' n dwells
    [s/output].
    """

    bench: BenchPrior
    seats: FloatArray
    by_accelerometer: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))


def _prior(
    bench: BenchParameters, dwells: Sequence[tuple[int, DwellRecord]], accelerometer: TriadFit | None,
    seat: FloatArray,
) -> _Prior:  # fmt: skip
    """Return what is known of the bench, and of the seats where ``seat`` (m,) [rad], their 1 sigma, is not empty.

    Slab and faces are as the accelerometers found them. Where moves show a cube's perpendicularity, it keeps its
    own prior: the accelerometers only held it.
    """
    prior = bench.priors()
    apart = np.diag(1 / np.repeat(seat, 2))
    if accelerometer is None or accelerometer.is_turned_freely:
        return _with_seating(prior, apart, np.zeros((len(prior.mean), len(apart))))
    freed = _freed(bench, accelerometer.bench) if bench.skew_seen else np.zeros(bench.size, dtype=bool)
    known = np.flatnonzero(~freed[: bench.shared])
    mean, own = accelerometer.fit.x[12 + known], accelerometer.fit.covariance[np.ix_(12 + known, 12 + known)]
    columns, by_rate = known, gain(accelerometer.fit, accelerometer.sigma)[12 + known]
    place = {(number, dwell.name): i for i, (number, dwell) in enumerate(dwells)}
    of = [place.get((number, dwell.name), -1) for number, dwell in accelerometer.seen.dwells]
    if len(seat) and -1 not in of:
        at = np.array([2 * i + k for i in of for k in (0, 1)])
        value, covariance, by_rate = seated(accelerometer, seat[of])
        index = np.concatenate((known, bench.shared + np.arange(len(at))))
        mean, own, by_rate = value[index], covariance[np.ix_(index, index)], by_rate[index]
        columns = np.concatenate((known, bench.size + at))
        apart = np.delete(apart, at, axis=0)
    white = np.linalg.inv(np.linalg.cholesky(own + TILT_FLOOR_RAD**2 * np.eye(len(own))))
    rows = np.zeros((len(own), bench.size + 2 * len(seat)))
    rows[:, columns] = white
    kept = np.any(prior.matrix[:, freed] != 0, axis=1)
    kept[-len(bench.placements) :] = True  # headings
    matrix = np.vstack((rows[:, : bench.size], prior.matrix[kept]))
    loose = np.concatenate((np.zeros(len(own), dtype=bool), prior.loose[kept]))
    joint = BenchPrior(np.concatenate((white @ mean, prior.mean[kept])), matrix, loose)
    seats = np.vstack((rows[:, bench.size :], np.zeros((int(kept.sum()), 2 * len(seat)))))
    return replace(_with_seating(joint, apart, seats), by_accelerometer=-white @ by_rate)


def _with_seating(prior: BenchPrior, apart: FloatArray, seats: FloatArray) -> _Prior:
    """Append the rows ``apart`` (r, 2 m) of seats of which nothing else is known."""
    if not len(apart):
        return _Prior(prior, seats)
    rows = np.zeros((len(apart), prior.matrix.shape[1]))
    loose = np.concatenate((prior.loose, np.zeros(len(apart), dtype=bool)))
    longer = BenchPrior(np.concatenate((prior.mean, np.zeros(len(apart)))), np.vstack((prior.matrix, rows)), loose)
    return _Prior(longer, np.vstack((seats, apart)))


def _freed(bench: BenchParameters, accelerometer: BenchParameters) -> BoolArray:
    """Say of the bench's parameters (p,) which perpendicularities the accelerometers only held."""
    freed = np.zeros(bench.size, dtype=bool)
    for cube in range(bench.cubes if not accelerometer.skew_known() else 0):
        begin = bench.cube_slice(cube).start + 6
        freed[begin : begin + 6] = np.repeat(accelerometer.held_pairs(cube), 2)
    return freed
