"""Soaks in the diagnosis: temperature that only rises is drift; up and down again it is temperature."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import ALL_POSITIONS, SimulatedBench, simulate_campaign
from drivers.simulated.truth import Truth
from procedures.campaign.campaign import Campaign, DwellRecord, SoakRecord
from procedures.campaign.plan_steps import Dwell
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis

RISING = {"temperature_swing_k": 6.0, "temperature_swing_period_s": 7200.0}  # rises in the dwells, then falls
WARM, DRIFT = "accelerometer.bias_temperature", "accelerometer.bias_drift"
DWELL_S, SOAK_S = 20.0, 2700.0


def warmed(seed: int, effects: dict[str, dict[str, float]], soak: int | None = 1) -> Campaign:
    """Return twelve positions while it grows warmer, and a soak in a position (0: at an attitude unknown)."""
    truth = replace(Truth.example(seed), effects=effects, sample_period_s=0.1, **RISING)
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
