"""Derivatives, covariances and the prior of the visual-inertial window, against numbers had in another way."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.arrays import FloatArray
from procedures.frames import rotation, rotation_vector, skew
from procedures.fusion.gnss_velocity import KeyframeFix, no_fix
from procedures.fusion.inner.landmarks import Landmarks, Sights, linearise, residuals
from procedures.fusion.inner.window_problem import Prior, WindowMeasurements, assemble, marginalised
from procedures.fusion.inner.window_state import CAMERA, COMMON, FRAME, HEADING, OFFSET, WindowState, zero
from procedures.fusion.inner.window_terms import add_inertial, fix_residuals, predicted
from procedures.fusion.pose_graph_terms import rz
from procedures.fusion.preintegration import ImuGrid, Preintegrated, preintegrate
from tests.procedures.fusion.motions import CAMERA as LENS
from tests.procedures.fusion.motions import NOISE, SITE

SCALE = np.array([458.0, 457.0])
ZERO = np.zeros(3)


def samples(rng: np.random.Generator, n: int = 20) -> ImuGrid:
    omega, f = rng.normal(0, 0.5, 3) + np.zeros((n, 3)), rng.normal(0, 1, 3) + np.array([9.8, 0.0, 0.0])
    return ImuGrid(np.full(n, 0.005), omega, f + np.zeros((n, 3)), np.zeros(0, np.int64))


def made(part: ImuGrid, bias: FloatArray, earth_b: FloatArray = ZERO) -> Preintegrated:
    return preintegrate(part, bias[:3], bias[3:], earth_b, NOISE)


def at_speed(v: FloatArray, weight: float) -> KeyframeFix:
    return replace(no_fix(), v=v, v_weight=np.full(3, weight))


def state_of(rng: np.random.Generator, frames: int) -> WindowState:
    """Return keyframes a decimetre apart that look along n's East."""
    look = Rotation.from_euler("y", 90, degrees=True) * Rotation.from_rotvec(rng.normal(0, 0.05, (frames, 3)))
    p = np.column_stack((np.zeros(frames), 0.3 * np.arange(frames), np.zeros(frames))) + rng.normal(
        0, 0.02, (frames, 3)
    )
    small = [rng.normal(0, 0.1, (frames, 3)) for _ in range(3)]
    return WindowState(look.as_matrix(), p, *small, LENS.C_bc, LENS.t_bc, 0.1, np.zeros((0, 3)))


def sights_of(rng: np.random.Generator, state: WindowState, count: int) -> Sights:
    """Return landmarks some metres East, seen from everywhere with a pixel's noise."""
    C_oc, p_c = state.C_ob @ state.C_bc, state.p + state.C_ob @ state.t_bc
    point = np.column_stack((rng.uniform(3, 6, count), rng.uniform(-1, 2, count), rng.uniform(-1, 1, count)))
    y = np.einsum("kji,lkj->lki", C_oc, point[:, None] - p_c)
    first = y[:, 0]
    at = np.column_stack((first[:, :2] / first[:, 2:], 1 / first[:, 2]))
    z = y[:, :, :2] / y[:, :, 2:] + rng.normal(0, 1, (*y.shape[:2], 2)) / SCALE
    return Sights(
        np.repeat(p_c[:1], count, axis=0), np.repeat(C_oc[:1], count, axis=0), at, z, np.ones(z.shape[:2], bool)
    )


def test_a_sample_error_carries_as_the_covariance_says() -> None:
    rng = np.random.default_rng(3)
    part = samples(rng)
    mean = made(part, np.zeros(6))
    ends = []
    for _ in range(1000):
        noisy = replace(
            part,
            omega_b=part.omega_b + rng.normal(size=part.omega_b.shape) * NOISE.gyro / 0.005**0.5,
            f_b=part.f_b + rng.normal(size=part.f_b.shape) * NOISE.accel / 0.005**0.5,
        )
        end = made(noisy, np.zeros(6))
        ends.append(np.r_[rotation_vector(mean.turn.T @ end.turn), end.dv - mean.dv, end.dp - mean.dp])
    stated = np.sqrt(np.diag(np.linalg.inv(mean.info)))[:6]
    assert np.allclose(np.std(ends, axis=0)[:6], stated, rtol=5 / np.sqrt(2 * 1000))  # 5 sigma of a sigma
    floor = np.hypot(np.std(ends, axis=0)[6:], np.sqrt(1e-8 * mean.dt))
    assert np.allclose(floor, np.sqrt(np.diag(np.linalg.inv(mean.info)))[6:], rtol=0.12)


@pytest.mark.parametrize("is_given", [True, False], ids=["offset given", "offset fitted"])
def test_derivatives_of_sights_are_those_of_differences(is_given: bool) -> None:
    rng = np.random.default_rng(5)
    state = state_of(rng, 3)
    state = replace(state, rate=None if is_given else rng.normal(0, 0.5, (3, 3)))
    sights = sights_of(rng, state, 4)
    visual = linearise(state, sights, SCALE)
    h = 1e-6

    def half_cost(at: WindowState, s: Sights) -> float:
        r = residuals(at, s, SCALE)[2]
        assert np.linalg.norm(r, axis=1).max() < 4.0
        size = np.linalg.norm(r, axis=1)
        return float(np.sum(np.where(size < 2.0, r.T**2 / 2, 0).sum(axis=0) + (size >= 2.0) * (2.0 * size - 2.0)))

    for column, at in enumerate(
        [*range(CAMERA), OFFSET, *(COMMON + 15 * k + i for k in range(3) for i in range(6))]
    ):
        step = np.zeros(state.size)
        step[at] = h
        slope = (half_cost(state.moved(step), sights) - half_cost(state.moved(-step), sights)) / (2 * h)
        assert slope == pytest.approx(visual.g[column], rel=1e-4, abs=1e-2)
    for mark in range(4):
        for axis in range(3):
            moved = np.zeros_like(sights.at)
            moved[mark, axis] = h
            pair = (half_cost(state, replace(sights, at=sights.at + sign * moved)) for sign in (1, -1))
            slope = (next(pair) - next(pair)) / (2 * h)
            assert slope == pytest.approx(visual.b[mark, axis], rel=1e-4, abs=1e-2)


def test_a_state_that_follows_its_own_prediction_costs_nothing_and_a_step_off_it_what_it_should() -> None:
    rng = np.random.default_rng(6)
    one = state_of(rng, 1)
    earth_b = one.C_ob[0].T @ rz(np.array(one.heading))[0].T @ SITE.earth_n
    part = made(samples(rng), np.r_[one.bg[0], one.ba[0]], earth_b)
    two = one.with_frame(*predicted(one, part, SITE), one.bg[0], one.ba[0])
    normal = zero(two.size)
    add_inertial(normal, two, [part], SITE)
    size = np.sqrt(np.diag(normal.A).clip(1e-12))
    assert np.abs(normal.g / size).max() < 1e-6
    step = rng.normal(size=two.size) * 1e-4 / size  # whitened, so small
    step[HEADING] /= 1e2  # the Earth's rate tells it within some rad only
    off = zero(two.size)
    add_inertial(off, two.moved(step), [part], SITE)
    assert np.allclose(off.g / size, normal.A @ step / size, atol=3e-7)


def test_what_was_marginalised_says_of_the_rest_what_it_reported_before() -> None:
    """The step of the frames that stay is the same, before a keyframe is eliminated and after."""
    rng = np.random.default_rng(8)
    state = state_of(rng, 3)
    parts = [made(samples(rng), np.r_[state.bg[k], state.ba[k]]) for k in range(2)]
    info = zero(COMMON + 15)
    info.A[:] = np.diag(rng.uniform(1, 1e4, len(info.g)))
    prior = Prior(info, state.part(slice(1)))
    held = WindowMeasurements(parts, [at_speed(each + 0.01, 400.0) for each in state.v])
    marks = Landmarks()
    sights = sights_of(rng, state, 12)
    for k in range(3):
        numbers = np.arange(12)[: 12 if k < 2 else 7]  # the last five are lost in the last frame
        marks.add_frame(numbers, sights.z[numbers, k])
    marks.settle(state)
    before, _ = assemble(state, prior, held, SITE, marks, marks.sights.seen, SCALE)
    step = -np.linalg.solve(before.A, before.g)
    kept = np.r_[0:COMMON, COMMON + 15 : COMMON + 45]
    left, _ = marginalised(state, prior, held, SITE, marks, SCALE)
    later = replace(state.part(slice(1, None)), held=left.at.held)
    assert len(left.at.held) == 7
    rest = WindowMeasurements(parts[1:], held.fixes[1:])
    after, _ = assemble(later, left, rest, SITE, marks, marks.sights.seen, SCALE)
    again = -np.linalg.solve(after.A, after.g)
    sigma = np.sqrt(np.diag(np.linalg.inv(before.A)))[kept]
    size = len(kept)
    assert np.abs((again[:size] - step[kept]) / sigma).max() < 0.02
    ratio = np.sqrt(np.diag(np.linalg.inv(after.A)))[:size] / sigma
    assert np.allclose(ratio, 1.0, atol=0.01)


STEP = 1e-6


def two_keyframes(rng: np.random.Generator) -> WindowState:
    p, v, bg, ba = rng.normal(size=(4, 2, 3))
    C_ob = rotation(rng.normal(size=(2, 3)))
    return WindowState(
        C_ob, p, v, bg, ba, np.eye(3), np.zeros(3), 0.3, np.zeros((0, 3)), antenna=rng.normal(size=4)
    )


def test_slopes_are_those_of_differences() -> None:
    rng = np.random.default_rng(1)
    state = two_keyframes(rng)
    v, p, lever, a = rng.normal(size=(4, 3))
    fix = KeyframeFix(v, np.ones(3), p, np.ones(3), -0.05, lever, rng.normal(size=(3, 3)), a)
    r, J, _ = fix_residuals(state, [1], [fix])
    columns = []
    for k in [*range(HEADING, COMMON), *range(COMMON + FRAME, COMMON + 2 * FRAME)]:
        step = np.zeros(state.size)
        step[k] = STEP
        columns.append((fix_residuals(state.moved(step), [1], [fix])[0][0] - r[0]) / STEP)
    assert np.allclose(J[0], np.array(columns).T, atol=1e-5)


def test_a_fix_of_the_true_antenna_leaves_no_residual() -> None:
    """A body flies straight and spins; its antenna is seen from a frame whose heading is not the window's.

    Where the antenna is and how fast are taken from its path, by differences in time, not from the terms.
    """
    rng = np.random.default_rng(3)
    state = two_keyframes(rng)
    k, omega_b, age = 1, rng.normal(size=3), -0.05
    lever, more, tau = rng.normal(size=3), state.antenna[:3], state.antenna[3]
    cosine, sine = np.cos(state.heading), np.sin(state.heading)
    C_no = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])

    def antenna_n(turned: float, moved: float) -> FloatArray:
        in_o = state.p[k] + state.v[k] * moved + state.C_ob[k] @ rotation(omega_b * turned) @ (lever + more)
        seen: FloatArray = C_no @ in_o
        return seen

    v_n = (antenna_n(STEP, STEP) - antenna_n(-STEP, -STEP)) / (2 * STEP)
    p_n = antenna_n(0.0, age + tau)
    fix = KeyframeFix(v_n, np.ones(3), p_n, np.ones(3), age, lever, skew(omega_b), np.zeros(3))
    r, _, _ = fix_residuals(state, [k], [fix])
    assert r[0] == pytest.approx(np.zeros(6), abs=1e-8)


def test_a_velocity_stamped_late_is_that_of_an_acceleration_before() -> None:
    state = two_keyframes(np.random.default_rng(4))
    a_n, none = np.array([1.0, -2.0, 0.5]), np.zeros(3)
    now = KeyframeFix(none, np.ones(3), none, none, 0.0, none, np.zeros((3, 3)), none)
    later = KeyframeFix(none, np.ones(3), none, none, 0.0, none, np.zeros((3, 3)), a_n)
    without, with_it = (fix_residuals(state, [0], [fix])[0][0, :3] for fix in (now, later))
    assert with_it - without == pytest.approx(a_n * state.antenna[3])
