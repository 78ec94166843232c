"""Rests and what is impossible in them: recordings of a known motion, scaled wrongly on purpose."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from procedures.rest_plausibility import (
    MAX_RAW_RATE,
    Assumption,
    Contradiction,
    Rest,
    RestSurvey,
    contradiction,
    explanations,
)  # fmt: skip

G, DEG = 9.80665, np.pi / 180
UP = np.array([0.1, -0.2, 1.0]) / np.linalg.norm([0.1, -0.2, 1.0])
TILTED = UP + np.array([0.05, 0.0, 0.0])


def still(seconds: float, hz: float, *, up: np.ndarray = UP, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """A unit at rest: noise of a MEMS, the Earth's rate and a small bias."""
    draw, n = np.random.default_rng(seed), round(seconds * hz)
    force = G * up + draw.normal(0, 0.02, (n, 3))
    return force, np.array([0.02, -0.01, 0.015]) * DEG + draw.normal(0, 0.05 * DEG, (n, 3))


def rests(force: np.ndarray, rate: np.ndarray, hz: float) -> list[Rest]:
    survey = RestSurvey(1 / hz)
    return [*survey.take(force, rate), *survey.finish()]


def turning(rate: np.ndarray, hz: float, *, up: np.ndarray = UP) -> tuple[np.ndarray, np.ndarray]:
    """A unit that turns at ``rate`` (n, 3) [rad/s] in its own axes; gravity as it then sees it."""
    turned, forces = Rotation.identity(), []
    for each in rate:
        turned = turned * Rotation.from_rotvec(each / hz)
        forces.append(turned.inv().apply(G * up))
    return np.array(forces), rate


@pytest.mark.parametrize("hz", [0.1, 1.0, 7.0, 50.0, 1000.0, 8000.0])
def test_a_unit_at_rest_rests_and_contradicts_nothing(hz: float) -> None:
    force, rate = still(max(3.0, 40 / hz), hz)
    found = rests(force, rate, hz)
    assert sum(rest.samples for rest in found) >= 0.8 * len(force) - 10
    assert found[0].length == pytest.approx(G, rel=0.01)
    assert contradiction(force, rate, hz) is None


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 0.125, 0.5, 2.0, 8.0, 60.0, 1e3, 1e6, 1 / G, 0.01])
@pytest.mark.parametrize("place", ["start", "middle", "end"])
def test_a_wrong_scale_contradicts_gravity_wherever_the_rest_is(factor: float, place: str) -> None:
    hz, draw = 100.0, np.random.default_rng(3)
    force, _ = still(2.0, hz)
    moving = G * UP + draw.normal(0, 1, (600, 3)).cumsum(axis=0) / 5
    order = {"start": [force, moving], "middle": [moving[:300], force, moving[300:]], "end": [moving, force]}[
        place
    ]
    found = contradiction(np.vstack(order) * factor, None, hz)
    assert isinstance(found, Contradiction)
    assert found.quantity == "specific force"
    assert found.rest is not None
    assert contradiction(np.vstack(order), None, hz) is None


def test_the_single_assumption_that_makes_it_right_is_among_those_named() -> None:
    hz, bias = 100.0, np.array([0.012, -0.008, 0.011])
    choices = [Assumption(f"{1 / f:g}", 1 / f) for f in (1e-6, 1e-3, 0.01, 0.25, 0.5, 2.0, 4.0, 60.0, 1e3, G)]
    for each in choices:
        force, _ = still(3.0, hz)
        raw = (force + bias) / each.factor  # what was taken for force and bias together
        found = contradiction(raw - bias, None, hz)
        assert found is not None
        named = explanations(found, choices, bias)
        assert each in named
        assert all(0.9 < other.factor / each.factor < 1.12 for other in named)


@pytest.mark.filterwarnings("error")
def test_a_rest_without_any_force_is_explained_by_no_scale() -> None:
    found = contradiction(np.zeros((500, 3)), None, 100.0)
    assert found is not None
    assert explanations(found, [Assumption("twice", 2.0)]) == []


def carousel(hz: float, *, axis: np.ndarray, speed: float, seconds: float = 8.0) -> tuple[np.ndarray, np.ndarray]:
    return turning(np.tile(axis * speed, (round(seconds * hz), 1)), hz)


@pytest.mark.parametrize("speed", [0.05, 0.3, 0.6, 2.0, 20.0, 300.0])
@pytest.mark.parametrize("axis", [UP, np.array([1.0, 0, 0]), TILTED / np.linalg.norm(TILTED)])
def test_a_turn_at_a_constant_rate_contradicts_nothing(axis: np.ndarray, speed: float) -> None:
    force, rate = carousel(100.0, axis=axis, speed=speed * DEG)
    assert contradiction(force, rate, 100.0) is None


def test_a_turntable_off_its_centre_adds_to_gravity() -> None:
    speed, radius = 300 * DEG, 0.5
    force = np.tile([speed**2 * radius, 0.0, G], (1000, 1))  # 16.9 m/s2
    assert contradiction(force, np.tile([0, 0, speed], (1000, 1)), 100.0) is None
    assert contradiction(force, np.zeros((1000, 3)), 100.0) is not None


@pytest.mark.parametrize("scale", [180 / np.pi, 100.0, 1000.0])
def test_a_gyroscope_scaled_too_large_is_seen_against_gravity_that_stands_still(scale: float) -> None:
    force, rate = still(20.0, 100.0)
    found = contradiction(force, rate * scale, 100.0)
    assert found is not None
    assert found.quantity == "angular rate"
    assert found.found > found.allowed > 0.1 * DEG
    assert Assumption("rad", 1 / scale) in explanations(found, [Assumption("rad", 1 / scale)])


def test_the_bias_of_an_uncalibrated_gyroscope_is_no_contradiction() -> None:
    force, rate = still(5.0, 100.0)
    biased = rate + np.array([3.0, -5.0, 1.0]) * DEG
    assert contradiction(force, biased, 100.0, max_rate=MAX_RAW_RATE) is None
    found = contradiction(force, biased, 100.0)
    assert found is not None
    assert found.found == pytest.approx(np.linalg.norm(np.cross(biased.mean(axis=0), UP)), rel=0.05)


@pytest.mark.parametrize("seed", range(2))
def test_motion_by_hand_and_of_vehicles_contradicts_nothing(seed: int) -> None:
    draw, hz, n = np.random.default_rng(seed), 100.0, 6000
    smooth = np.exp(-np.arange(200) / (20.0 + 10 * seed))

    def drift(size: float) -> np.ndarray:
        raw = np.apply_along_axis(np.convolve, 0, draw.normal(0, 1, (n, 3)), smooth, "same")
        return size * raw / raw.std()

    force, rate = turning(drift((3, 15, 60)[seed % 3] * DEG), hz)
    force = force + drift((0.1, 0.5, 2.0)[seed % 3])
    assert contradiction(force, rate + 0.03 * DEG, hz) is None
