"""Rows that a placement, rotation or transfer adds to the joint fit, linearised about a perfect bench.

They are differences of the models that the solve minimises: `GyroscopeModel.output`, `BenchParameters` and
`procedures.twelve_positions.placement_transfers`. K is the identity, so that its rows are relative. Columns are
first `OWN` of each placement: heading, two of the seating, a rotation's closure error, all [rad]; then `SHARED`:
K (9) and b (3) [g] of the accelerometers, K (9) and b (3) [deg/s] of the gyroscopes, and the bench's (15) that
belong to no placement.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray, IntArray
from procedures.campaign.campaign import Campaign, DwellRecord, TurnRecord
from procedures.campaign.observations import TriadDwells, TurnTotal
from procedures.counts.sample_records import CountSeries
from procedures.frames import rotation_vector
from procedures.geodesy import earth_rate_n
from procedures.planning.campaign_design import TURNS, HandTimes
from procedures.positions import ATTITUDES
from procedures.twelve_positions.accelerometer_fit import gravity_n
from procedures.twelve_positions.bench_parameters import BenchParameters
from procedures.twelve_positions.gyroscope_model import GyroscopeModel
from procedures.twelve_positions.manual_rotations import RotationGeometry, nominal_angle
from procedures.twelve_positions.placement_transfers import carried_rotations, seating_rotations
from procedures.twelve_positions.transfer_rotation import integrate_moves, padded_moves
from procedures.units import RAD_PER_DEG

TRIAD = 12  # K and b
ACCEL, GYRO, BENCH = slice(0, TRIAD), slice(TRIAD, 2 * TRIAD), slice(2 * TRIAD, 2 * TRIAD + 15)  # of the shared
SHARED = BENCH.stop
HEADING, SEAT, CLOSURE, OWN = 0, slice(1, 3), 3, 4
DIFFERENCE_STEP_RAD = 1e-5
MOVE_SAMPLES = 60  # of a move of even speed: the integral is then good to 1e-4 of itself


@dataclass(frozen=True, slots=True, eq=False)
class PlacementRows:
    """Rows by what they are of, in g, deg/s, deg and rad.

    ``accel`` and ``gyro`` (24, 3, 4 + 39) are of dwells, ``turn`` (6, 3, 4 + 39) of turns, ``move`` (24, 24, 3,
    4 + 4 + 39) of moves from one position to another: own columns of the placement before, of the one after,
    shared.
    """

    accel: FloatArray
    gyro: FloatArray
    turn: FloatArray
    move: FloatArray
    bench: BenchParameters


def placement_rows(campaign: Campaign, hands: HandTimes) -> PlacementRows:
    """Return the rows of all placements, turns and moves on the bench of a campaign, whatever its own steps."""
    n = len(ATTITUDES)
    model = _model(campaign, hands)
    of_dwells, of_turns = _gyroscope_rows(model, n)
    return PlacementRows(
        _accelerometer_rows(model, n), of_dwells, of_turns, _move_rows(model, n, hands), model.bench
    )


def _model(campaign: Campaign, hands: HandTimes) -> GyroscopeModel:
    """Return the gyroscopes' model of a dwell in every attitude and the six turns."""
    none = CountSeries(np.zeros(0), None, None, np.zeros(0), 1.0)
    dwells = tuple((0, DwellRecord(name, i + 1, none)) for i, name in enumerate(ATTITUDES))
    seen = TriadDwells(dwells, np.zeros((len(dwells), 3)), np.ones((len(dwells), 3)), np.ones(3), ())
    turns = []
    for step in TURNS:
        record = TurnRecord(step.name, step.axis, step.direction, step.revolutions, step.start_position, none)
        turns.append(TurnTotal(0, record, np.zeros(3), np.ones(3), hands.turn, True))
    level = np.diag([0.0, 0.0, hands.turn])  # whole revolutions see the horizontal from every side
    shapes = [RotationGeometry(nominal_angle(turn), campaign.sigma.closure, level, False) for turn in turns]
    return GyroscopeModel([campaign], seen, turns, shapes, None, None)


def _differences(of: Callable[[FloatArray], FloatArray], ways: FloatArray) -> FloatArray:
    """Return the derivative (..., w) of a function of angles at zero, along each of the ``ways`` (w, size)."""
    steps = DIFFERENCE_STEP_RAD * ways
    return np.stack([(of(d) - of(-d)) / (2 * DIFFERENCE_STEP_RAD) for d in steps], axis=-1)


def _all_of(size: int, *those: slice) -> FloatArray:
    """Return ways (w, size) along which all angles of a slice move at once: what depends on one knows no other."""
    ways = np.zeros((len(those), size))
    for way, each in zip(ways, those, strict=True):
        way[each] = 1.0
    return ways


def _gyroscope_rows(model: GyroscopeModel, n: int) -> tuple[FloatArray, FloatArray]:
    start = np.concatenate((np.eye(3).ravel(), np.zeros(model.size - 9)))
    bench, turns = model.bench, len(model.turns)

    def output(change: FloatArray) -> FloatArray:
        x = start.copy()
        x[: TRIAD + bench.size] += change[: TRIAD + bench.size]
        x[TRIAD + bench.size :] = change[TRIAD + bench.size :] / RAD_PER_DEG  # closures
        return model.output(x)

    first, end = TRIAD + bench.shared, TRIAD + bench.size
    ways = np.vstack((np.eye(model.size)[:first], _all_of(model.size, slice(first, end), slice(end, None))))
    by, normal = _differences(output, ways), bench.to_cube(np.zeros(bench.size))[:, :, 2]
    found = np.zeros((n + turns, 3, OWN + SHARED))
    shared = found[..., OWN:]
    shared[..., GYRO], shared[..., BENCH] = by[..., :TRIAD], by[..., TRIAD:first]
    found[..., HEADING] = by[..., first]
    for i, rows in enumerate(found):
        if i >= n:
            rows[:, CLOSURE] = by[i, :, first + 1]
            tilts = np.cross(seating_rotations([bench.placements[i].position])[0], normal[i][:, None], axis=0)
            rows[:, SEAT] = model.angle[i - n] * bench.C_sb[i] @ tilts  # it turns about the slab's normal
    return found[:n], found[n:]


def _seated(model: GyroscopeModel, n: int) -> tuple[Callable[[FloatArray], FloatArray], FloatArray, FloatArray]:
    """Return what takes shared bench parameters, headings and seats to attitudes (n, 3, 3), and ways of theirs.

    First those of each shared parameter, then the three of all headings and of both tilts of all seats.
    """
    bench = model.bench
    rotations = seating_rotations([at.position for at in bench.placements])

    def attitudes(change: FloatArray) -> FloatArray:
        x, seats = np.zeros(bench.size), np.zeros((len(bench.placements), 2))
        x[: bench.shared + n] = change[: bench.shared + n]
        seats[:n] = change[bench.shared + n :].reshape(n, 2)
        return bench.attitudes(x, (rotations @ seats[..., None])[..., 0])[:n]

    size, seats = bench.shared + 3 * n, bench.shared + n
    headings, tilts = slice(bench.shared, seats), (slice(seats, None, 2), slice(seats + 1, None, 2))
    return attitudes, np.eye(size)[: bench.shared], _all_of(size, headings, *tilts)


def _accelerometer_rows(model: GyroscopeModel, n: int) -> FloatArray:
    bench, C_sb = model.bench, model.bench.C_sb[:n]
    attitudes, of_bench, of_own = _seated(model, n)

    def force(change: FloatArray) -> FloatArray:
        x = np.concatenate((change[: bench.shared], np.zeros(bench.size - bench.shared)))
        return (C_sb @ attitudes(change) @ gravity_n(bench, x)[0][:, None])[..., 0]

    by, u = _differences(force, np.vstack((of_bench, of_own))), force(np.zeros(of_own.shape[1]))
    found = np.zeros((n, 3, OWN + SHARED))
    shared = found[..., OWN:]
    shared[..., :9] = np.einsum("qp,nj->nqpj", np.eye(3), u).reshape(n, 3, 9)
    shared[..., 9:TRIAD], shared[..., BENCH] = np.eye(3), by[..., : bench.shared]
    found[..., :CLOSURE] = by[..., bench.shared :]
    return found


def _move_rows(model: GyroscopeModel, n: int, hands: HandTimes) -> FloatArray:
    bench, C_sb = model.bench, model.bench.C_sb[0]
    attitudes, of_bench, of_own = _seated(model, n)
    before, after = (~np.eye(n, dtype=bool)).nonzero()
    earth = earth_rate_n(bench.campaigns[0].site.latitude)[None]
    seconds, level = np.full(len(before), hands.move), attitudes(np.zeros(of_own.shape[1]))

    def carried(first: FloatArray, then: FloatArray) -> FloatArray:
        return carried_rotations(C_sb[None], first[before], then[after], earth, seconds)

    nominal = np.swapaxes(carried(level, level), 1, 2)

    def turned(first: FloatArray, then: FloatArray) -> FloatArray:
        return rotation_vector(carried(first, then) @ nominal)

    found = np.zeros((n, n, 3, 2 * OWN + SHARED))
    shared = found[..., 2 * OWN :]
    shared[before, after, :, GYRO] = _of_even_speed(C_sb @ level, before, after, hands.move)
    shared[before, after, :, BENCH] = _differences(lambda d: turned(at := attitudes(d), at), of_bench)
    found[before, after, :, :CLOSURE] = _differences(lambda d: turned(attitudes(d), level), of_own)
    found[before, after, :, OWN : OWN + CLOSURE] = _differences(lambda d: turned(level, attitudes(d)), of_own)
    found[..., CLOSURE] = found[..., HEADING]  # a turn's end is turned as a heading is
    return found


def _of_even_speed(C_sn: FloatArray, before: IntArray, after: IntArray, seconds: float) -> FloatArray:
    """Return the change (m, 3, 12) of a move's rotation with K and b, the shortest way at an even speed.

    ``C_sn`` (n, 3, 3) takes East-North-Up to the IMU's axes; of half a turn both ways are as short.
    """
    way = -Rotation.from_matrix(C_sn[after] @ np.swapaxes(C_sn[before], 1, 2)).as_rotvec(degrees=True)
    output = np.repeat((way / seconds)[:, None], MOVE_SAMPLES, axis=1)
    samples = padded_moves(list(output), [seconds / MOVE_SAMPLES] * len(way))
    return integrate_moves(samples, np.eye(3), np.zeros(3)).sensitivity
