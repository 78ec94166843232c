"""Rows of a rate table that contradict the others are named, and no error term is taken for them."""

from collections.abc import Callable

import numpy as np
import pytest

from procedures.anomalies.wrong_rates import find_wrong_rates
from procedures.arrays import FloatArray
from procedures.campaign.campaign import RateTable
from procedures.inference.priors import PRESENT

NOISE = 3e-4  # deg/s
ONE_WAY = np.array([0, 5, -5, 10, -10, 20, -20, 50, -50, 100, -100, 150, -150, 200, -200, 250, -250, 300, -300.0])
SLOW = np.array([0, 0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.2, 0.3, 0.5, 1, 2])
ORDERS = {
    "twice": np.tile(ONE_WAY, 2),
    "up and down": np.concatenate((np.sort(ONE_WAY), np.sort(ONE_WAY)[::-1])),
    "each once": np.linspace(-300, 300, 31),
}
TEMPERATURE = 20 + 30 * np.linspace(0, 1, 60) ** 0.7

Effect = Callable[[FloatArray, FloatArray], FloatArray]  # of the rates and the row numbers, both (n,)
EFFECTS: dict[str, Effect] = {
    "none": lambda u, i: 0 * u,
    "asymmetry": lambda u, i: 20e-6 * np.abs(u),
    "cubic": lambda u, i: 60e-6 * u**3 / 300**2,
    "sagnac sine": lambda u, i: np.sin(2e-3 * u) / 2e-3 - u,
    "sine of the rate": lambda u, i: 0.01 * np.sin(2 * np.pi * u / 120),
    "dead zone": lambda u, i: -np.clip(u, -12, 12),
    "narrow dead zone": lambda u, i: -np.clip(u, -0.04, 0.04),
    "saturation": lambda u, i: np.clip(u, -220, 220) - u,
    "soft end": lambda u, i: -1e-3 * np.maximum(np.abs(u) - 180, 0) * np.sign(u),
    "jump": lambda u, i: 0.02 * (i >= len(u) // 3),
    "late jump": lambda u, i: 0.02 * (i >= len(u) - 3),
    "drift": lambda u, i: 0.01 * i / len(u),
    "settling": lambda u, i: 0.05 * np.exp(-i / 3),
    "scale factor settles": lambda u, i: -300e-6 * u * np.exp(-i / 5),
    "bias of temperature": lambda u, i: 4e-3 * TEMPERATURE[: len(u)],
    "scale factor of temperature": lambda u, i: 2e-5 * u * TEMPERATURE[: len(u)],
    "cubic and drift": lambda u, i: 40e-6 * u**3 / 300**2 + 0.006 * i / len(u),
    "one rate is off": lambda u, i: 0.03 * (u == u[7]),
}


def table(u: FloatArray, effect: Effect, seed: int, *, with_temperature: bool = True) -> RateTable:
    rng = np.random.default_rng(seed)
    output = np.full((len(u), 3), np.nan)
    seen = u + effect(u, np.arange(len(u)))
    output[:, 2] = 1.00031 * seen + 0.0021 + NOISE * rng.standard_normal(len(u))
    T = TEMPERATURE[: len(u)] if with_temperature else np.full(len(u), np.nan)
    return RateTable("rates.csv", "z", u, output, T)


def likely(one: RateTable) -> tuple[int, ...]:
    return tuple(sorted(each.row for each in find_wrong_rates(one, 2) if each.probability >= PRESENT))


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("effect", EFFECTS)
def test_no_error_term_is_taken_for_wrong_rows(effect: str, order: str) -> None:
    if (effect, order) == ("one rate is off", "each once"):
        pytest.skip("a rate taken once that is off is a row that is off")
    has_T = "temperature" in effect
    for seed in range(2):
        assert likely(table(ORDERS[order], EFFECTS[effect], seed, with_temperature=has_T)) == ()


@pytest.mark.parametrize("repeats", [2, 3])
def test_a_lock_in_is_no_wrong_row(repeats: int) -> None:
    u = np.tile(np.concatenate((SLOW, -SLOW[1:])), repeats)
    for half in (0.04, 0.025):
        for effect in (
            lambda u, i, half=half: np.sign(u) * np.sqrt(np.maximum(u**2 - half**2, 0)) - u,
            lambda u, i, half=half: -np.clip(u, -half, half),
        ):
            assert likely(table(u, effect, 1, with_temperature=False)) == ()


def sign(u: FloatArray, y: FloatArray) -> tuple[int, ...]:
    y[12] *= -1
    return (12,)


def exchanged(u: FloatArray, y: FloatArray) -> tuple[int, ...]:
    y[[11, 12]] = y[[12, 11]]
    return (11, 12)


def digit(u: FloatArray, y: FloatArray) -> tuple[int, ...]:
    y[21] *= 10
    return (21,)


def off(sigmas: float) -> Callable[[FloatArray, FloatArray], tuple[int, ...]]:
    def by(u: FloatArray, y: FloatArray) -> tuple[int, ...]:
        y[21] += sigmas * NOISE
        return (21,)

    return by


def three(u: FloatArray, y: FloatArray) -> tuple[int, ...]:
    y[[3, 14, 22]] += np.array([0.5, -3.0, 40.0])
    return (3, 14, 22)


@pytest.mark.parametrize("order", ["twice", "each once"])
@pytest.mark.parametrize("effect", ["asymmetry", "cubic", "drift"])
@pytest.mark.parametrize("wrong", [sign, exchanged, digit, off(20), off(200), three])
def test_wrong_rows_are_named(
    wrong: Callable[[FloatArray, FloatArray], tuple[int, ...]], effect: str, order: str
) -> None:
    one = table(ORDERS[order], EFFECTS[effect], 1, with_temperature=False)
    rows = wrong(one.reference, one.output[:, 2])
    assert likely(one) == rows


def test_a_rate_at_the_end_of_the_range_taken_once_is_not_accused() -> None:
    one = table(ORDERS["each once"], EFFECTS["none"], 0, with_temperature=False)
    one.output[-1, 2] += 200 * NOISE
    assert likely(one) == ()


def test_size_and_sigmas_are_those_of_the_error() -> None:
    one = table(ORDERS["twice"], EFFECTS["none"], 0, with_temperature=False)
    one.output[21, 2] += 0.04
    (found,) = find_wrong_rates(one, 2)
    assert abs(found.off - 0.04) < 5 * NOISE
    assert 0.5 < found.sigmas / (0.04 / NOISE) < 1.5
