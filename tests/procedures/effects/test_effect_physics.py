"""Effects against what they must be: the bench's own columns, the Sagnac sine, the change of specific force."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.effects import EFFECTS, sagnac_sine
from procedures.effects.effect import Effect
from procedures.effects.excitation import TAU, Columns, Excitation, ExcitationStep
from procedures.effects.jump import accelerometer_columns
from procedures.effects.temperature_history import sensor_temperature
from procedures.effects.term.functions import sine_less_one
from tests.procedures.effects.test_every_effect import BY_NAME, baseline


def base_columns(first: int, count: int) -> FloatArray:
    """The base model's own columns H of bench parameters, which follow twelve of the triads'."""
    return -baseline().evidence.A[:, 12 + first : 12 + first + count]


@pytest.mark.parametrize(("name", "first", "count"), [("slab.tilt", 0, 2), ("fixture.parallelism", 3, 6)])
def test_a_bench_effect_is_the_base_models_own_column(name, first, count) -> None:
    evidence = baseline().evidence
    rows = evidence.rows("mean", "turn")
    H = evidence.column(BY_NAME[name].columns(evidence.excitation)[0])[rows]
    own = base_columns(first, count)[rows]
    assert np.all(np.linalg.norm(H - own, axis=0) < 2e-3 * np.linalg.norm(own, axis=0))


def test_face_tilts_are_the_base_models_parallelism_and_perpendicularity() -> None:
    evidence = baseline().evidence
    rows = evidence.rows("mean", "turn")
    H = evidence.column(BY_NAME["fixture.face_tilt"].columns(evidence.excitation)[0])[rows].reshape(-1, 3, 2, 2)
    for own, ours in ((base_columns(3, 6), H.mean(axis=2)), (base_columns(9, 6), H[:, :, 0] - H[:, :, 1])):
        off = np.linalg.norm(ours.reshape(-1, 6) - own[rows], axis=0)
        assert np.all(off < 2e-3 * np.linalg.norm(own[rows], axis=0))


def test_the_cubic_is_the_sagnac_sine_to_first_order() -> None:
    seen = baseline().evidence.excitation
    cubic = BY_NAME["gyroscope.scale_nonlinearity"].columns(seen)[1]
    sine = BY_NAME["gyroscope.sagnac_sine"].columns(seen)[0]
    assert np.allclose(sine.gyro, -1e6 / 6 * cubic.gyro, rtol=1e-12)


@pytest.mark.parametrize("s", [1e-5, 8e-4, 4e-3, 2e-2])
def test_the_sagnac_sine_is_exact_beyond_the_first_order(s: float) -> None:
    seen, q = baseline().evidence.excitation, np.full(3, s**2)
    total, change = sagnac_sine.added(seen, q)
    assert np.allclose(total, np.sin(s * seen.omega) / s - seen.omega, rtol=1e-9, atol=1e-12)
    step = 1e-3 * s**2
    higher, lower = (sagnac_sine.added(seen, q + d)[0] for d in (step, -step))
    assert np.allclose(np.einsum("nqq->nq", change), (higher - lower) / (2 * step), rtol=1e-5, atol=1e-4)


def test_a_sagnac_phase_is_shown_with_its_own_sigma() -> None:
    q, std = np.array([4e-6, 0.0, -1e-8]), np.array([4e-8, 1e-8, 1e-8])
    s, s_std = sagnac_sine.shown(q, std)
    assert s == pytest.approx([2e-3, 0.0, -1e-4])
    assert s_std == pytest.approx([4e-8 / 4e-3, 1e-4, 0.414e-4], rel=0.01)


def test_relaxation_may_go_by_the_change_of_specific_force() -> None:
    seen = baseline().evidence.excitation
    relaxation = BY_NAME["accelerometer.relaxation"].at
    same, by_change = (
        relaxation(seen, Columns((), shape=s, nonlinear={TAU: 8.0})) for s in ("", "by the change of f")
    )
    second = [step.name for step in seen.steps].index("dwell_03")
    at = seen.step == second
    change = np.array([0.0, 9.79 / 9.80665, 0.0]) * -2  # IMU y points along cube x, which goes from up to down
    expected = same.accel[at] * change[:, None]
    assert by_change.unit == "g/g"
    assert np.allclose(by_change.accel[at], expected, rtol=1e-9)
    assert not np.any(by_change.accel[seen.step == 0])


@pytest.mark.parametrize("effect", [e for e in EFFECTS if e.shown], ids=lambda effect: effect.name)
def test_what_is_shown_leads_back_to_what_was_fitted(effect: Effect) -> None:
    assert effect.shown is not None
    assert effect.fitted is not None
    c = np.array([4e-6, -9e-6, 0.0])
    assert effect.fitted(effect.shown(c, np.full(3, 1e-7))[0]) == pytest.approx(c)


# The sine of a Sagnac interferometer against numpy's own functions, on both sides of nought


def test_it_is_the_sine_over_its_angle_less_one_and_the_hyperbolic_one_of_a_negative_square() -> None:
    angle = np.array([[1e-6, 1e-3, 0.03], [0.3, 1.0, 3.0]])
    assert sine_less_one(angle**2) == pytest.approx(np.sinc(angle / np.pi) - 1, rel=1e-9, abs=1e-15)
    assert sine_less_one(-(angle**2)) == pytest.approx(np.sinh(angle) / angle - 1, rel=1e-6, abs=1e-12)
    assert sine_less_one(np.zeros((1, 3))).tolist() == [[0.0, 0.0, 0.0]]


# Places of a jump


NODES = 16  # of a step, a second each


def rests(*campaigns: int) -> Excitation:
    """Return an excitation of so many rests a campaign, p0.csv, p1.csv and so on in each."""
    steps = tuple(
        ExcitationStep(f"p{i}.csv", "rest", n, 0, "") for n, count in enumerate(campaigns) for i in range(count)
    )
    begin = np.concatenate([np.arange(count) for count in campaigns]) * (NODES + 4.0)
    n = NODES * len(steps)
    vector, one = np.ones((n, 3)), np.ones(n)
    unit = np.tile(np.eye(3), (n, 1, 1))
    inside = np.tile(np.arange(NODES, dtype=float), len(steps))
    return Excitation(
        f=vector, omega=vector, magnetic=vector, accel_output=vector, gyro_output=vector, change=vector,
        t=np.repeat(begin, NODES) + inside, rest_s=inside, temperature=one, temperature_rate=one, auxiliary={},
        step=np.repeat(np.arange(len(steps)), NODES), C_sb=unit, E_accel=unit, E_gyro=unit, steps=steps,
    )  # fmt: skip


def test_a_jump_of_one_campaign_is_not_anothers_whose_files_have_the_same_names() -> None:
    seen = rests(5, 5)
    ways = accelerometer_columns(seen)
    assert len({(way.shape, *way.where.items()) for way in ways}) == len(ways)
    campaign = seen.per_step("campaign")
    for way in ways:
        assert way.accel is not None
        acts = way.accel.any(axis=(1, 2))
        assert set(campaign[acts] + 1) == {way.where["campaign"]}


# The temperature that a sensor follows: one lag or two, from the equilibrium before the campaign


WARM_UP_K, WARM_UP_S, LAG_S, STEP = 8.0, 900.0, 400.0, 0.5


def warmed(t: np.ndarray) -> np.ndarray:
    return 20.0 + WARM_UP_K * (1 - np.exp(-t / WARM_UP_S))


def test_the_lag_of_a_unit_that_was_switched_on_a_minute_before_begins_where_it_did() -> None:
    """Against Euler's steps from 20 degC at power-on; by the tangent a minute back it is 0.02 K more."""
    seen = rests(80)
    seen = replace(seen, t=seen.t + 60.0)
    rate = WARM_UP_K / WARM_UP_S * np.exp(-seen.t / WARM_UP_S) * 60
    seen = replace(seen, temperature=warmed(seen.t), temperature_rate=rate)
    grid = np.arange(0.0, seen.t[-1] + STEP, STEP)
    states, T = np.full(len(grid), 20.0), warmed(grid)
    for i in range(1, len(grid)):
        states[i] = states[i - 1] + STEP / LAG_S * (T[i - 1] - states[i - 1])
    assert np.max(np.abs(sensor_temperature(seen, LAG_S) - np.interp(seen.t, grid, states))) < 0.025
