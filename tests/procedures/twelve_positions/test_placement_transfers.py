from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drivers.simulated.cube_motion import carry
from procedures.arrays import FloatArray
from procedures.calibration.triad_calibration import TriadVector, triad_vector
from procedures.campaign.campaign import Campaign
from procedures.counts.sample_records import CountSeries, RateSeries
from procedures.errors import MoveContradicts
from procedures.frames import rotation_vector
from procedures.positions import ATTITUDES, POSITIONS, face_of, nominal_C_lb
from procedures.twelve_positions.accelerometer_fit import solve_accelerometer
from procedures.twelve_positions.gyroscope_fit import GyroscopeFit, solve_gyroscope
from procedures.twelve_positions.transfer_rotation import (
    MoveSamples,
    finer_moves,
    integrate_moves,
    move_rotations,
    padded_moves,
)
from tests.procedures.twelve_positions.carried_cube import Carried, attitude, campaign, carried
from tests.refusals import refused

ARCSEC = np.pi / 180 / 3600
OFF_DIAGONAL = [4, 5, 6, 8, 9, 10]  # of E, in k, E, D
SEEDS = (1, 2, 3)


def solved(of: Carried, specified: Campaign | None = None) -> tuple[GyroscopeFit, TriadVector]:
    specified = specified or of.campaign
    accelerometer = solve_accelerometer([specified], of.accelerometer)
    found = solve_gyroscope([specified], of.gyroscope, [], accelerometer)
    assert found is not None
    return found, triad_vector(found.joint, "gyroscope", accelerometer)


@pytest.fixture(scope="module")
@cache
def solutions() -> list[tuple[Carried, GyroscopeFit, TriadVector]]:
    made = [campaign(seed, POSITIONS) for seed in SEEDS]
    return [(each, *solved(each)) for each in made]


def test_twelve_positions_and_the_moves_between_them_give_the_gyroscopes_without_a_turn(
    solutions: list[tuple[Carried, GyroscopeFit, TriadVector]],
) -> None:
    error = np.array([vector.value - of.truth for of, _, vector in solutions])
    sigma = np.array([np.sqrt(np.diag(vector.covariance)) for _, _, vector in solutions])
    specified = np.hstack(((error / sigma)[:, :3], (error / sigma)[:, OFF_DIAGONAL], (error / sigma)[:, 12:]))
    assert np.abs(specified).max() < 4
    assert np.sqrt(np.mean(specified**2)) < 1.4
    assert np.all(sigma[:, :3] / 36000 < 7e-6)
    assert np.all(sigma[:, OFF_DIAGONAL] < 1.8 * ARCSEC)
    assert np.all(sigma[:, 12:] < 0.016)


def test_moves_measure_how_perpendicular_the_cube_is(
    solutions: list[tuple[Carried, GyroscopeFit, TriadVector]],
) -> None:
    for of, found, _ in solutions:
        joint = found.joint
        q = joint.bench.perpendicularity(joint.fit.x[12:])
        skew = np.array([q[0, 0] + q[1, 0], q[0, 1] + q[2, 0], q[1, 1] + q[2, 1]])
        assert np.abs(skew - of.skew).max() < 5 * ARCSEC
        assert np.abs(of.skew).max() > 5 * ARCSEC  # else it would not show


def test_the_residual_is_as_large_as_it_should_be(
    solutions: list[tuple[Carried, GyroscopeFit, TriadVector]],
) -> None:
    for _, found, _ in solutions:
        assert 0.4 < found.joint.fit.chi2 / found.joint.dof < 1.6
        assert found.moves is not None
        assert np.abs(found.moves.error / found.moves.sigma[:, None]).max() < 4.5


def test_a_placement_with_a_wrong_heading_is_reported_to_contradict_its_moves() -> None:
    made = campaign(4, POSITIONS)
    steps = list(made.campaign.dwells)
    steps[4] = replace(steps[4], position=6)  # the same face, turned by half a turn
    seen = replace(made.gyroscope, dwells=tuple((0, step) for step in steps))
    with refused(MoveContradicts) as caught:
        solve_gyroscope([replace(made.campaign, dwells=tuple(steps))], seen, [], None)
    assert isinstance(caught.value, MoveContradicts)
    assert caught.value.move in {"move_03", "move_04"}
    assert caught.value.off_deg == pytest.approx(180, abs=10)


@pytest.mark.parametrize(("seconds", "hz"), [(4.0, 100.0), (4.0, 50.0), (25.0, 50.0), (10.0, 400.0)])
def test_what_turning_between_samples_costs_lies_within_its_stated_sigma(seconds: float, hz: float) -> None:
    rng, within = np.random.default_rng(7), list[bool]()
    flat = np.zeros((6, 2)), np.zeros(2), 0.0, np.zeros(2)
    begin = attitude("UEN", *flat)
    for letters in ("UWS", "DNE", "DSW", "NUE") * 2:
        end = attitude(letters, *flat)
        angle = carried(begin, end, seconds, hz, rng)
        t = np.arange(1.0, len(angle) + 1) / hz
        fine = np.rint(np.degrees(angle).cumsum(axis=0) * 1e9)  # a count that costs nothing
        counts = np.diff(np.vstack((np.zeros(3), fine)), axis=0).astype(np.int64)
        series = CountSeries(t, counts, None, np.full(len(t), np.nan), 1 / hz)
        moves, at = finer_moves([series]), (1e9 * np.eye(3), np.zeros(3))
        earth = Rotation.from_rotvec(-7.292115e-5 * seconds * np.array([0, np.cos(0.55), np.sin(0.55)]))
        error = (
            Rotation.from_matrix(moves.integrate(*at).rotation[0]) * (end * earth * begin.inv()).inv()
        ).as_rotvec()
        within += (np.abs(error) < np.maximum(2 * moves.coning(*at)[0], 0.02 * ARCSEC)).tolist()
    assert np.mean(within) >= 0.95


def test_the_24_attitudes_are_all_there_are_and_the_twelve_keep_their_numbers() -> None:
    assert ATTITUDES[:12] == POSITIONS
    found = {nominal_C_lb(number).tobytes() for number in range(1, 25)}
    assert len(found) == 24
    assert all(np.isclose(np.linalg.det(nominal_C_lb(number)), 1) for number in range(1, 25))
    for number in range(1, 25, 2):  # two and two stand on one face, turned by half a turn
        assert face_of(number) == face_of(number + 1)
        assert np.allclose(nominal_C_lb(number) * [[-1], [-1], [1]], nominal_C_lb(number + 1))


# Moves too fast for their sample rate are not used


ORDER = tuple("ENU ESD USE DSW SUW NDW NWU SWD UWS DES EUS EDN".split())


def test_fast_moves_are_left_out_and_reported_and_the_others_solve() -> None:
    slow, fast = campaign(3, ORDER, seconds=25.0, hz=50.0), campaign(3, ORDER, seconds=4.0, hz=12.5)
    moves = (*slow.campaign.moves[:-1], fast.campaign.moves[-1])
    made = replace(slow, campaign=replace(slow.campaign, moves=moves))
    accelerometer = solve_accelerometer([made.campaign], made.accelerometer)
    fit = solve_gyroscope([made.campaign], made.gyroscope, [], accelerometer)
    assert fit is not None
    assert fit.moves is not None
    [reported] = fit.moves.moves.left_out
    assert reported.startswith("move_10 not used: moved too fast, ")
    assert reported.endswith(" arcsec of coning")
    assert len(fit.moves.moves.records) == 10
    vector = triad_vector(fit.joint, "gyroscope", accelerometer)
    off = (vector.value - made.truth)[:3] / np.sqrt(np.diag(vector.covariance))[:3]
    assert np.abs(off).max() < 4


def carried_in(seed: int, hz: float, seconds: float, pause_s: float) -> tuple[np.ndarray, float]:
    """Return a carried cube's rotation less what is integrated [rad], and 1 sigma of what coning leaves of it."""
    rng = np.random.default_rng(seed)
    before, after = (nominal_C_lb(int(p)).T for p in rng.choice(range(1, 13), 2, replace=False))
    samples = round(seconds * hz)
    held = carry(before, after, samples, 1 / hz, rng, float(rng.uniform(20, 60)), pause_s)
    t, still = np.arange(1, samples + 1) / hz, np.zeros((samples, 3))
    series = RateSeries(t, np.degrees(held.rates), still, np.zeros(samples), 1 / hz, np.array([0]))
    moves, at = finer_moves([series]), (np.eye(3), np.zeros(3))
    seen = moves.integrate(*at).rotation[0]
    return rotation_vector(seen @ (after @ before.T).T), float(moves.coning(*at)[0])


@pytest.mark.parametrize("seconds", [20.0])
def test_what_coning_leaves_is_in_its_sigma_where_a_hand_trembles_and_stops(seconds: float) -> None:
    found = [carried_in(seed, 50.0, seconds, 2.0) for seed in range(20)]
    z = np.array([error / sigma for error, sigma in found])
    assert np.sqrt(np.mean(z**2)) < 2.0
    assert np.abs(z).max() < 7  # it stops within no time, which no hand does


# The change of a move's rotation with K and b is the derivative of the rotation, however long a sample is


K = np.array([[36000.0, 30.0, -20.0], [-10.0, 35500.0, 15.0], [25.0, -40.0, 36400.0]])  # output/deg
B = np.array([5.0, -3.0, 2.0])  # output/s
STEPS = np.array([10.0] * 9 + [1.0] * 3)  # output/deg, output/s


def half_turn(axis: FloatArray, hz: float, seconds: float = 4.0) -> MoveSamples:
    """Half a turn about ``axis`` (3,), smooth, all within the middle half of the time."""
    u = np.clip((np.linspace(0.0, 1.0, round(seconds * hz) + 1) - 0.25) / 0.5, 0.0, 1.0)
    rates = 180.0 * np.diff(u**3 * (10 - 15 * u + 6 * u * u))[:, None] * hz * axis / np.linalg.norm(axis)
    return padded_moves([rates @ K.T + B], [1 / hz])


def derivative(samples: MoveSamples, change: FloatArray) -> FloatArray:
    """The rotation vector (3,) [rad] by which a small ``change`` (12,) of K and b turns the end of the move."""
    ends = [
        move_rotations(samples, K + way * change[:9].reshape(3, 3), B + way * change[9:])[0] for way in (0.5, -0.5)
    ]
    turned: FloatArray = -rotation_vector(ends[0] @ ends[1].T)
    return turned


@pytest.mark.parametrize(("hz", "within"), [(20.0, 2e-3), (50.0, 2e-4)])
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.0, 0.6, 0.8), (0.5, -0.7, 0.5)])
def test_the_change_of_a_rotation_is_its_derivative(
    axis: tuple[float, float, float], hz: float, within: float
) -> None:
    """Half a sample's turn next to it, 0.05 at 20 Hz, and what nothing shows would seem to be known."""
    samples = half_turn(np.array(axis), hz)
    found = integrate_moves(samples, K, B)
    assert Rotation.from_matrix(found.rotation[0] @ move_rotations(samples, K, B)[0].T).magnitude() < 1e-12
    expected = np.array([derivative(samples, step) / step.max() for step in np.diag(STEPS)]).T
    off, size = (np.linalg.norm(each, axis=0) for each in (found.sensitivity[0] - expected, expected))
    assert off[:9].max() < within * size[:9].max()
    assert off[9:].max() < within * size[9:].max()
