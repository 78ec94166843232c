from dataclasses import replace

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.calibration.triad_calibration import triad_vector
from procedures.campaign.campaign import Campaign, TurnRecord
from procedures.campaign.observations import TriadDwells, turn_totals
from procedures.counts.sample_records import RateSeries, Series
from procedures.twelve_positions.gyroscope_fit import GyroscopeFit, solve_gyroscope
from tests.procedures.independent import body_from_level, campaign, dwells

PERIOD, FINE = 0.02, 20
LATITUDE = 0.55
EARTH_DEG_S = np.degrees(7.292115e-5) * np.array([0.0, np.cos(LATITUDE), np.sin(LATITUDE)])
K_TRUE = np.array([36000.0, 35500.0, 36700.0])
E_TRUE = np.array([[1.0, 2e-3, -1e-3], [5e-4, 1.0, 3e-3], [-2e-3, 1e-3, 1.0]])
E_TRUE = E_TRUE / np.linalg.norm(E_TRUE, axis=1)[:, None]
D_TRUE = np.array([3e-4, -2e-4, 1e-4])  # deg/s
TINY = 3e-7  # relative: 0.3 ppm, a fiftieth of what the closure leaves open
START = {"x": 1, "y": 5, "z": 9}
DOWN = {"x": 3, "y": 7, "z": 11}


def heading_of(seed: int, total: float, rest_s: float = 3.0, swing: float = 0.6) -> tuple[FloatArray, FloatArray]:
    """Heading [rad] and its speed on a grid `FINE` times finer than the samples: rest, an uneven turn, rest."""
    rng = np.random.default_rng(seed)
    n = round((25 + 10 * rng.random()) / PERIOD)
    u = (np.arange(n * FINE) + 0.5) / (n * FINE)
    speed = np.sin(np.pi * u) ** 2 * (1 + swing * np.sin(2 * np.pi * (u * rng.integers(1, 4) + rng.random())))
    speed *= total / (speed.sum() * PERIOD / FINE)
    rest = np.zeros(round(rest_s / PERIOD) * FINE)
    speed = np.concatenate((rest, speed, rest))
    heading = np.cumsum(speed) * PERIOD / FINE - speed * PERIOD / FINE / 2
    return heading, speed


def turn(
    axis: str, direction: str, seed: int, *, position: int | None = None, closure: float = 0.0, rest_s: float = 3.0
) -> TurnRecord:
    """A noise-free turn of a rate output, integrated from the cube's attitude at every instant.

    Seen from above the heading grows counter-clockwise: a vector fixed in the level frame goes clockwise as the
    cube sees it. Right-handed about an axis that points down is clockwise from above.
    """
    position = START[axis] if position is None else position
    C = body_from_level(position)
    up = C[:, 2]
    sense = (1 if direction == "+" else -1) * up["xyz".index(axis)]
    psi, speed = heading_of(seed, sense * 6 * np.pi + closure, rest_s)
    level = np.stack([
        np.cos(psi) * EARTH_DEG_S[0] + np.sin(psi) * EARTH_DEG_S[1],
        -np.sin(psi) * EARTH_DEG_S[0] + np.cos(psi) * EARTH_DEG_S[1],
        np.full_like(psi, EARTH_DEG_S[2]) + np.degrees(speed),
    ], axis=1)  # fmt: skip
    omega = (level @ C.T).reshape(-1, FINE, 3).mean(axis=1)
    output = K_TRUE * (omega @ E_TRUE.T + D_TRUE)
    t = PERIOD * np.arange(1.0, len(output) + 1)
    series = RateSeries(t, output, None, np.full(len(t), np.nan), PERIOD)
    name = f"turn_{axis}_{'plus' if direction == '+' else 'minus'}"
    return TurnRecord(name, axis, direction, 3, position, series)


def six(**kwargs: float) -> tuple[TurnRecord, ...]:
    return tuple(turn(a, d, 10 * i + j, **kwargs) for i, a in enumerate("xyz") for j, d in enumerate("+-"))  # type: ignore[arg-type]


def resting() -> TriadDwells:
    u = np.array([body_from_level(p) @ EARTH_DEG_S for p in range(1, 13)])
    return dwells(K_TRUE * (u @ E_TRUE.T + D_TRUE), 0.36)


def bench(turns: tuple[TurnRecord, ...]) -> Campaign:
    return campaign(turns=turns, latitude=LATITUDE)


def solved(turns: tuple[TurnRecord, ...], noise: float = 3.6) -> GyroscopeFit | None:
    where = bench(turns)
    return solve_gyroscope([where], resting(), turn_totals([where], np.full(3, noise)), None)


def numbers(fit: GyroscopeFit | None) -> tuple[FloatArray, FloatArray, FloatArray]:
    assert fit is not None
    value = triad_vector(fit.joint, "gyroscope", None).value
    return value[:3], value[3:12].reshape(3, 3), value[12:] / 3600


def assert_true(fit: GyroscopeFit | None) -> None:
    k, E, D = numbers(fit)
    assert np.abs(k / K_TRUE - 1).max() < TINY
    assert np.abs(E - E_TRUE).max() < TINY
    assert np.abs(D - D_TRUE).max() < 1e-3 / 3600  # a thousandth of a deg/h; the Earth is 15


def test_without_noise_uneven_turns_and_the_earth_s_rate_are_solved_exactly() -> None:
    assert_true(solved(six()))


@pytest.mark.parametrize("axis", "xyz")
def test_an_axis_that_points_down_is_turned_the_other_way(axis: str) -> None:
    turns = [t for t in six() if t.axis != axis]
    turns += [turn(axis, d, 50 + j, position=DOWN[axis]) for j, d in enumerate("+-")]
    assert_true(solved(tuple(turns)))


def test_the_closure_is_the_sigma_of_the_scale_factor() -> None:
    fit = solved(six())
    assert fit is not None
    closure = bench(()).sigma.closure
    found = triad_vector(fit.joint, "gyroscope", None)
    relative = np.sqrt(np.diag(found.covariance))[:3] / found.value[:3]
    assert relative == pytest.approx(
        closure / (6 * np.pi) / np.sqrt(2), rel=0.03
    )  # two turns of three revolutions; the rest is misalignment times tilts that no accelerometer saw


def test_an_error_of_closure_is_found_within_its_sigma() -> None:
    rng = np.random.default_rng(1)
    closure = bench(()).sigma.closure
    z = []
    for _ in range(6):
        turns = tuple(
            turn(t.axis, t.direction, i, closure=closure * rng.standard_normal()) for i, t in enumerate(six())
        )
        fit = solved(turns)
        assert fit is not None
        found = triad_vector(fit.joint, "gyroscope", None)
        z.append((found.value[:3] - K_TRUE) / np.sqrt(np.diag(found.covariance))[:3])
    assert np.abs(z).max() < 4
    assert 0.5 < np.sqrt(np.mean(np.square(z))) < 1.6  # 18 values: 3.5 sigma of their rms


def cut(series: Series, begin: int, end: int) -> Series:
    """The series without samples begin .. end, as a gap."""
    keep = np.r_[0:begin, end : len(series)]
    return replace(
        series, t=series.t[keep], gyro=series.gyro[keep], temperature=series.temperature[keep],  # type: ignore[index]
        starts=np.array([0, begin]),
    )  # fmt: skip


def test_a_turn_with_a_gap_while_turning_is_left_out_and_named() -> None:
    turns = list(six())
    middle = len(turns[1].series) // 2
    turns[1] = replace(turns[1], series=cut(turns[1].series, middle, middle + 5))
    fit = solved(tuple(turns))
    assert fit is not None
    assert fit.broken == ("turn_x_minus",)
    assert [t.record.name for t in fit.turns] == [
        "turn_x_plus",
        "turn_y_plus",
        "turn_y_minus",
        "turn_z_plus",
        "turn_z_minus",
    ]
    assert_true(fit)


def test_without_whole_turns_about_an_axis_there_is_no_gyroscope() -> None:
    turns = six()
    assert solved(tuple(t for t in turns if t.axis != "y")) is None
    assert solved(()) is None
    broken = tuple(
        replace(t, series=cut(t.series, len(t.series) // 2, len(t.series) // 2 + 5)) if t.axis == "z" else t
        for t in turns
    )
    assert solved(broken) is None


@pytest.mark.parametrize("sensor", range(3))
def test_a_gyro_that_answers_no_turn_leaves_the_triad_unsolved(sensor: int) -> None:
    answers = np.arange(3) != sensor
    deaf = tuple(replace(t, series=replace(t.series, gyro=t.series.gyro * answers)) for t in six())  # type: ignore[operator]
    where, seen = bench(deaf), resting()
    seen = replace(seen, rate=seen.rate * answers)
    assert solve_gyroscope([where], seen, turn_totals([where], np.full(3, 3.6)), None) is None


@pytest.mark.parametrize("scatter", [0.0, 0.3])
def test_scatter_from_dwell_to_dwell_beyond_noise_is_found(scatter: float) -> None:
    """The bias wanders by ``scatter`` counts/s between dwells whose noise is 0.1 of it."""
    rng = np.random.default_rng(2)
    found = []
    where = bench(six())
    totals = turn_totals([where], np.full(3, 1e-3))
    for _ in range(10):
        seen = resting()
        noise = 0.03
        rate = seen.rate + np.hypot(scatter, noise) * rng.standard_normal((12, 3))
        fit = solve_gyroscope([where], replace(seen, rate=rate, std=np.full((12, 3), noise)), totals, None)
        assert fit is not None
        found.append(fit.joint.excess)
        z = (fit.joint.b - K_TRUE * D_TRUE) / np.sqrt(np.diag(fit.joint.fit.covariance))[9:12]
        assert np.abs(z).max() < 4
    mean = np.mean(np.square(found))
    if scatter:
        assert mean == pytest.approx(scatter**2, rel=0.4)  # 330 degrees of freedom: 4 sigma is 31 %
    else:
        assert mean < noise**2  # only what chance adds, and never less than nothing
