"""The order of a polynomial: the simplest that foretells as well; the time constant of a lag and its sigma."""

from dataclasses import replace

import numpy as np
import pytest

from procedures.campaign.campaign import Campaign, ProcedureSigma, Site, SoakRecord
from procedures.counts.sample_records import RateSeries
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis

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
    names = ["x", "y", "z"] if order == 1 else ["x.1", *(f"y.{n + 1}" for n in range(order)), "z.1"]
    assert list(values) == names
    for truth, name in zip(c, [n for n in names if n[0] == "y"], strict=True):
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
    (finding,) = diagnose([replace(whole, soaks=(replace(soak, series=series),))]).findings
    assert finding.effect == "accelerometer.bias_drift"
    assert finding.confidence == "ambiguous"
    assert "accelerometer.bias_temperature" in finding.aliases
