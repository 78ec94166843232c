"""P1's numbers, an independent derivation by the simulator and the real solve, symmetries."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.simulated.bench_in_memory import SimulatedBench
from drivers.simulated.truth import paper_truth
from procedures.arrays import FloatArray
from procedures.calibration.triad_calibration import triad_vector
from procedures.campaign.plan_steps import Dwell
from procedures.positions import C_bn
from procedures.tolerance.drawing_items import ITEMS, angles, p1_tilts
from procedures.tolerance.estimator_errors import ToleranceUnit, estimator_errors
from procedures.twelve_positions.accelerometer_fit import closed_form, solve_accelerometer
from tests.procedures.independent import TABLE_4_D, TABLE_4_E, THETA, campaign, dwells
from tests.refusals import refused

IDEAL = ToleranceUnit(np.eye(3), np.zeros(3), np.zeros(3))
P1_ITEMS = angles(dict.fromkeys(ITEMS, 0.04), 400.0)
EVERY = range(1, 13)
tilts_of = st.lists(st.floats(-1e-3, 1e-3), min_size=12, max_size=12).map(lambda t: np.array(t).reshape(6, 2, 1))


def normalised(E: FloatArray) -> FloatArray:
    return E / np.linalg.norm(E, axis=1)[:, None]


PAPER = ToleranceUnit(normalised(TABLE_4_E), TABLE_4_D, np.zeros(3))


def random_case(seed: int) -> tuple[ToleranceUnit, FloatArray]:
    rng = np.random.default_rng(seed)
    E = normalised(np.eye(3) + 2e-3 * rng.standard_normal((3, 3)))
    return ToleranceUnit(
        E, 2e-3 * rng.standard_normal(3), 4e-5 * rng.standard_normal(3)
    ), 1e-4 * rng.standard_normal((6, 2))


def rates(unit: ToleranceUnit, tilts: FloatArray) -> FloatArray:
    """Rates (12, 3) over k, through the rotations of `procedures.frames`: not those of the module under test."""
    u = np.stack([C_bn(p, np.zeros(2), tilts[(p - 1) // 2])[:, 2] for p in EVERY])
    f = u @ unit.E.T
    return f + unit.D + unit.K2 * f**2


def test_p1_s_cube_gives_equations_13_18_19_and_20() -> None:
    found = estimator_errors(p1_tilts(P1_ITEMS)[..., None], PAPER)
    t, E, k = THETA, PAPER.E, 1 + found.scale_factor[:, 0]
    s, c = np.sin, np.cos
    x = (2 * c(t) - 2 * c(3 * t) + 20 * s(t)) / 12
    y = (2 * c(3 * t) - 2 * c(5 * t) + 8 * s(t)) / 12
    z = (2 * c(3 * t) - 2 * c(5 * t) + 12 * s(t)) / 12
    eq13 = (TABLE_4_D + E @ [x, y, z]) / k - TABLE_4_D
    assert found.bias[0, :, 0] == pytest.approx(eq13, abs=20 * t**3)  # sin 5t = 5 sin t in the print
    half = (c(3 * t) - c(5 * t)) / 2
    rows = [
        [(c(t) - c(3 * t)) / 2, s(t) / 2, 1.5 * s(t)],
        [2.5 * s(t), half, 1.5 * s(t)],
        [2.5 * s(t), 1.5 * s(t), half],
    ]
    eq18 = np.sum(E * np.array(rows), axis=1)
    assert found.bias[1, :, 0] == pytest.approx(eq18, abs=2.1e-3 * 1.4e-6)  # D (k / k~ - 1), left out of (18)
    ideal = estimator_errors(p1_tilts(P1_ITEMS)[..., None], IDEAL)
    assert ideal.bias[0, :, 0] == pytest.approx(s(t) * np.array([5 / 3, 2 / 3, 1]), rel=5e-4)  # (19): + 8 t^2 / 6
    assert np.abs(ideal.bias[1]).max() <= 4.01 * t**2  # (20): cosines are left
    assert found.bias[0, :, 0] == pytest.approx([1.6704e-4, 0.6711e-4, 1.0065e-4], abs=0.6e-8)
    assert found.bias[1, :, 0] == pytest.approx([5.21e-7, 6.90e-7, 10.91e-7], abs=0.6e-9)


def test_p1_s_cube_gives_table_5() -> None:
    found = estimator_errors(p1_tilts(P1_ITEMS)[..., None], PAPER)
    k = np.array([1020, 1015, 1018]) * (1 + found.scale_factor[:, 0])
    assert k == pytest.approx([1019.99867, 1014.99974, 1017.99936], abs=3e-4)
    printed = [[0.99999593, 0.00075038, 0.00275005], [0.00204977, 0.99999723, 0.00114942],
               [0.00285018, 0.0021493, 0.99999363]]  # fmt: skip
    assert PAPER.E + found.misalignment[..., 0] == pytest.approx(np.array(printed), abs=1e-6)


@pytest.mark.parametrize("seed", range(2))
def test_the_paper_s_estimators_are_those_of_the_closed_form_on_any_cube(seed: int) -> None:
    unit, tilts = random_case(seed)
    form = closed_form(rates(unit, tilts), np.ones((12, 3)))
    found = estimator_errors(tilts[..., None], unit)
    assert unit.D + found.bias[0, :, 0] == pytest.approx(form.bias_12_position, abs=1e-15)
    assert unit.D + found.bias[1, :, 0] == pytest.approx(form.bias_two_direction, abs=1e-15)
    assert 1 + found.scale_factor[:, 0] == pytest.approx(form.scale_factor, abs=1e-14)
    assert unit.E + found.misalignment[..., 0] == pytest.approx(form.misalignment, abs=1e-14)


@pytest.mark.parametrize("seed", range(2))
def test_the_joint_bias_is_that_of_the_real_solve_on_any_cube(seed: int) -> None:
    unit, tilts = random_case(seed)
    joint = solve_accelerometer([campaign()], dwells(1000 * rates(unit, tilts), 1e-6))
    assert joint is not None
    solved = triad_vector(joint, "accelerometer", joint).value[12:]
    found = estimator_errors(tilts[..., None], unit).bias[2, :, 0]
    assert unit.D + found == pytest.approx(solved, abs=1e-12)  # the solve stops at 1e-3 of a sigma of 1e-9 g
    assert np.abs(found).max() > 1e-7  # K2 is there, so there is something to agree on


def test_tilted_cubes_simulated_count_by_count_give_the_same_errors() -> None:
    """Through the simulator: P1's cube, without noise; its counter's quantisation over 40 s is what remains."""
    bench = SimulatedBench(replace(paper_truth(), **quiet()), seed=1)
    truth = bench.truth
    counts = [bench.perform(Dwell(p, 40.0)).accel for p in EVERY]
    rate = np.array([np.asarray(c).sum(axis=0) / 40.0 for c in counts]) / truth.accel_k
    form = closed_form(rate, np.ones((12, 3)))
    found = estimator_errors(truth.faces_rad[..., None], PAPER)
    resolution = 1.0 / 40.0 / 1015.0  # g: one count in 40 s
    assert np.abs(form.bias_12_position - TABLE_4_D - found.bias[0, :, 0]).max() < resolution
    assert np.abs(form.bias_two_direction - TABLE_4_D - found.bias[1, :, 0]).max() < resolution


def quiet() -> dict[str, float]:
    return dict.fromkeys(("accel_noise_g", "gyro_arw_deg_rt_s", "settle_rad", "heading_std_deg"), 0.0)


@given(tilts_of, st.floats(0.01, 1.0))
def test_the_12_position_error_grows_as_the_tilts_and_the_others_as_their_square(
    tilts: FloatArray, factor: float
) -> None:
    size = float(np.hypot(tilts[:, 0], tilts[:, 1]).max())
    plain, smaller = (
        estimator_errors(tilts, IDEAL).bias,
        estimator_errors(factor * tilts, IDEAL).bias,
    )
    assert smaller[0] == pytest.approx(factor * plain[0], abs=2 * size**2 + 1e-15)
    assert smaller[1:] == pytest.approx(factor**2 * plain[1:], abs=20 * size**3 + 1e-15)


@given(tilts_of)
def test_a_perfectly_parallel_cube_spoils_no_bias_of_an_aligned_unit(tilts: FloatArray) -> None:
    """Opposite faces parallel, however skew: the up vectors of a pair are each other's negative."""
    tilts[1::2] = -tilts[::2]
    assert np.abs(estimator_errors(tilts, IDEAL).bias).max() < 1e-14


def test_wrong_items_are_refused_by_name() -> None:
    with refused(ValueError, None, "t11", "t3"):
        angles({item: 0.04 for item in ITEMS if item != "t3"} | {"t11": 0.04}, 400.0)
    with refused(ValueError, None, "t1", "-1"):
        angles(dict.fromkeys(ITEMS, 0.04) | {"t1": -1.0}, 400.0)
    with refused(ValueError, None, "side", "0"):
        angles(dict.fromkeys(ITEMS, 0.04), 0.0)
