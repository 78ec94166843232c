"""Temperature coefficients, their order, lags with their time constant, and drifts that may be temperature."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import ALL_POSITIONS, SimulatedBench, simulate_campaign
from drivers.simulated.truth import Truth
from procedures.arrays import FloatArray
from procedures.campaign.campaign import Campaign, DwellRecord, ProcedureSigma, Site, SoakRecord
from procedures.campaign.plan_steps import Dwell
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.diagnose import diagnose
from procedures.effects.temperature_history import lagged
from procedures.inference.result import Diagnosis

T = 20 + 25 * np.sin(np.arange(10800) / 1700) + 15 * -np.expm1(-np.arange(10800) / 2000)  # degC, a second each
NOISE = 2e-4  # g, of a sample


def campaign(seed: int, added: np.ndarray) -> Campaign:
    """Return three hours at rest of a unit whose y accelerometer has something added (n,) [g]."""
    rng = np.random.default_rng(seed)
    accel = np.array([1.0, 0.0, 0.0]) + NOISE * rng.standard_normal((len(T), 3))
    accel[:, 1] += added
    series = RateSeries(np.arange(1.0, len(T) + 1), None, accel, T, 1.0)
    return Campaign(
        model="a", serial="b", counts=False, site=Site(0.9, 9.80665, 1e-5, None), dwells=(), turns=(),
        sigma=ProcedureSigma(1e-3, 1e-3), soaks=(SoakRecord("soak", 0, None, series),),
        nominal_scale={"accelerometer": 1.0},
    )  # fmt: skip


def following(tau: float) -> np.ndarray:
    """Return T_s (n,) in steps of a second."""
    found = T.copy()
    for i in range(1, len(T)):
        found[i] = found[i - 1] + (T[i] - found[i - 1]) / tau
    return found


def coefficients(found: Diagnosis) -> dict[str, dict[str, tuple[float, float]]]:
    return {
        each.effect: {
            k: (float(v), float(s)) for k, v, s in zip(each.coefficients, each.value, each.std, strict=True)
        }
        for each in found.findings
    }


@pytest.mark.parametrize("order", [1, 3])
def test_the_order_is_found_for_the_sensor_that_bends(order: int) -> None:
    c = np.array([3e-6, 8e-8, 4e-9])[:order]
    warm = T - 25
    found = coefficients(diagnose([campaign(order, sum(c[i] * warm ** (i + 1) for i in range(order)))]))
    assert list(found) == ["accelerometer.bias_temperature"]
    values = found["accelerometer.bias_temperature"]
    for truth, name in zip(c, ["y"] if order == 1 else [f"y.{n + 1}" for n in range(order)], strict=True):
        value, std = values[name]
        assert abs(value - truth) < 4 * std


@pytest.mark.parametrize("tau", [300.0])
def test_a_time_constant_comes_out_within_its_own_sigma(tau: float) -> None:
    c = 4e-6 * max(1.0, 600.0 / tau)
    found = coefficients(diagnose([campaign(round(tau), c * (following(tau) - 25))]))
    assert list(found) == ["accelerometer.temperature_lag"]
    for name, truth in (("y", c), ("tau_s", tau)):
        value, std = found["accelerometer.temperature_lag"][name]
        assert abs(value - truth) < 4 * std
        assert std < 0.2 * truth


def test_a_drift_of_a_unit_without_a_thermometer_may_be_its_temperature() -> None:
    whole = campaign(4, 2e-5 * np.arange(len(T)) / 3600)
    (soak,) = whole.soaks
    series = replace(soak.series, temperature=np.full(len(T), np.nan))
    found = diagnose([replace(whole, soaks=(replace(soak, series=series),))])
    (cause,) = (*found.findings, *found.unnamed)
    assert {"accelerometer.bias_drift", "a temperature that was not recorded, accelerometer"} <= set(cause.shares)
    assert not [each for each in found.findings if each.probability > 0.9]


# A lag of a lag is no certain lag


def sure(found: Diagnosis) -> set[str]:
    return {each.effect for each in found.findings if each.kind == "instrument" and each.confidence != "possible"}


def twice(first: float, second: float) -> np.ndarray:
    """Return what lags behind what lags (n,), in steps of a second."""
    once = following(first)
    found = once.copy()
    for i in range(1, len(T)):
        found[i] = found[i - 1] + (once[i] - found[i - 1]) / second
    return found


@pytest.mark.proof
@pytest.mark.parametrize("tau", [900.0])
def test_a_lag_of_a_lag_is_no_lag_for_sure(tau: float) -> None:
    found = diagnose([campaign(11, 2e-5 * (twice(tau, tau) - 25))])
    assert "accelerometer.temperature_lag" not in sure(found)
    assert found.verdict in {"partly", "unexplained", "ambiguous"}


def test_a_lag_is_still_one() -> None:
    found = diagnose([campaign(12, 2e-5 * (following(900.0) - 25))])
    assert sure(found) == {"accelerometer.temperature_lag"}


# Runs in an oven at one attitude


KNOTS_S, KNOTS_C = np.array([0, 20, 70, 90, 150]) * 60.0, np.array([20.0, 20.0, 55.0, 55.0, 20.0])
OVEN_T = np.arange(0, 9000.0, 1.0)
UP = np.array([0.012, -0.02, 0.9997])


def oven(seed: int, accel: FloatArray | float, gyro: FloatArray | float, t: FloatArray = OVEN_T) -> Diagnosis:
    """Diagnose ``accel`` [g] and ``gyro`` [deg/s] (n, 3) at ``t`` [s] (n,), noisy as a cheap unit's 1 s means."""
    rng = np.random.default_rng(seed)
    n, temperature = len(t), np.interp(t, KNOTS_S, KNOTS_C)
    f = UP + accel + 1e-4 * rng.standard_normal((n, 3))
    w = gyro + 1.3e-3 * rng.standard_normal((n, 3)) + np.array([0.11, -0.07, 0.02])
    series = RateSeries(t + 1.0, w, f, temperature + 0.02 * rng.standard_normal(n), 1.0)
    soaks = (SoakRecord("oven", 0, None, series),)
    reported = {"accelerometer": 1.0, "gyroscope": 1.0}
    return diagnose([Campaign("m", "s", False, Site(0.8, 9.8, 0.02), (), (), soaks=soaks, nominal_scale=reported)])


def on(axis: int, values: FloatArray) -> FloatArray:
    return np.outer(values, np.eye(3)[axis])


@pytest.mark.proof
@pytest.mark.parametrize("seed", [1])
def test_a_lag_and_lines_in_the_temperature_are_named_and_none_is_ambiguous(seed: int) -> None:
    temperature = np.interp(OVEN_T, KNOTS_S, KNOTS_C) - 25
    follows = lagged(OVEN_T, np.interp(OVEN_T, KNOTS_S, KNOTS_C), 540.0) - 25
    found = oven(seed, on(2, 85e-6 * follows) + on(0, -30e-6 * temperature), on(1, 4.2 / 3600 * temperature))
    by_name = {each.effect: each for each in found.findings}
    assert set(by_name) == {
        "gyroscope.bias_temperature", "accelerometer.temperature_lag", "accelerometer.bias_temperature",
    }  # fmt: skip
    assert {each.confidence for each in found.findings} <= {"established", "likely"}
    assert found.verdict in {"established", "likely"}
    lag = dict(zip(by_name["accelerometer.temperature_lag"].coefficients,
                   by_name["accelerometer.temperature_lag"].value, strict=True))  # fmt: skip
    assert lag["z"] == pytest.approx(85e-6, rel=0.1)
    assert lag["tau_s"] == pytest.approx(540, rel=0.15)
    assert by_name["accelerometer.temperature_lag"].same_here == ("accelerometer.scale_temperature_lag",)
    assert by_name["accelerometer.bias_temperature"].same_here == ("accelerometer.scale_temperature",)
    assert by_name["gyroscope.bias_temperature"].same_here == ()


def test_what_no_effect_does_is_not_explained_with_one_that_is() -> None:
    """Two cycles of 500 s, once in the run: no temperature, no drift, no jump, and no cycle that lasts."""
    t = OVEN_T[:5400]  # until it is hot
    temperature = np.interp(t, KNOTS_S, KNOTS_C) - 25
    burst = np.where((t > 2000) & (t < 3100), np.sin(2 * np.pi * t / 500.0), 0.0)
    found = oven(3, on(2, 6e-5 * burst), on(1, 4.2 / 3600 * temperature), t)
    assert found.verdict in {"partly", "unexplained"}
    assert found.reasons
    gyro = next(each for each in found.findings if each.effect == "gyroscope.bias_temperature")
    assert gyro.confidence != "possible"  # what the accelerometers do says nothing of it


# Positions while the unit warms up, with and without a soak: temperature or drift


RISING = {"temperature_swing_k": 6.0, "temperature_swing_period_s": 7200.0}  # rises in the dwells, then falls
WARM, DRIFT = "accelerometer.bias_temperature", "accelerometer.bias_drift"
DWELL_S, SOAK_S = 20.0, 2700.0


def warmed(seed: int, effects: dict[str, dict[str, float]], soak: int | None = 1) -> Campaign:
    """Return twelve positions while it grows warmer, and a soak in a position (0: at an attitude unknown)."""
    truth = replace(Truth.example(seed), effects=effects, sample_period_s=0.5, **RISING)
    plain = simulate_campaign(truth, seed, dwell_s=DWELL_S, turns=(), certificate_sigma=2e-6)
    bench = SimulatedBench(truth, seed)
    dwells = tuple(DwellRecord(f"dwell_{p:02d}", p, bench.perform(Dwell(p, DWELL_S))) for p in ALL_POSITIONS)
    if soak is None:
        return replace(plain, dwells=dwells)
    series = bench.perform(Dwell(soak or 1, SOAK_S))
    return replace(plain, dwells=dwells, soaks=(SoakRecord("soak", soak, None, series),))


def findings(diagnosis: Diagnosis) -> dict[str, tuple[str, ...]]:
    return {each.effect: each.aliases for each in diagnosis.findings}


@pytest.mark.parametrize(("planted", "other"), [(WARM, DRIFT)])
def test_temperature_and_drift_are_one_while_it_only_grows_warmer_and_two_with_a_soak(
    planted: str, other: str
) -> None:
    size = {"x": 3e-6, "y": -2e-6, "z": 4e-6} if planted == WARM else {"x": 6e-5, "y": -4e-5, "z": 8e-5}
    without = findings(diagnose([warmed(3, {planted: size}, None)]))
    found = diagnose([warmed(3, {planted: size})])
    alone = findings(found)
    assert planted not in without or other in without[planted]
    assert planted in alone
    assert other not in alone
    assert other not in alone[planted]
    finding = next(each for each in found.findings if each.effect == planted)
    off = (finding.value - np.array(list(size.values()))) / finding.std
    assert np.max(np.abs(off)) < 4


def test_the_base_solution_does_not_use_a_soak_and_a_healthy_unit_has_nothing() -> None:
    with_soak, without = diagnose([warmed(5, {})]), diagnose([warmed(5, {}, None)])
    first, second = with_soak.solution_before.accelerometer, without.solution_before.accelerometer
    assert first is not None
    assert second is not None
    assert np.array_equal(first.bias.value, second.bias.value)
    assert not [each for each in with_soak.findings if each.kind == "instrument" and not each.aliases]
