"""What each effect of the catalogue adds to the sensors at the nodes of one campaign, a coefficient at a time."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import ALL_POSITIONS, SimulatedBench, simulate_campaign
from procedures.calibration.joint_calibration import fit
from procedures.campaign.campaign import DwellRecord, SoakRecord
from procedures.campaign.plan_steps import Dwell, turn_steps
from procedures.diagnosis.residual_rows import Evidence, evidence_of
from procedures.effects import EFFECTS
from procedures.effects.effect import Effect
from tests.benchmarks.diagnosing.designs import unit
from tests.stored.held import assert_held

WARM = {"temperature_rise_k": 6.0, "temperature_tau_s": 900.0, "temperature_swing_k": 2.0}


@cache
def evidence() -> Evidence:
    """Twelve positions, turns and a soak of a unit in a field that grows warmer, an auxiliary channel beside."""
    truth = unit(3, **WARM, temperature_swing_period_s=1300.0, magnetic_enu_ut=np.array([-3.0, 34.0, -36.0]))
    plain = simulate_campaign(truth, 3, dwell_s=10.0, turns=turn_steps(1, 2.0), certificate_sigma=5e-6)
    bench = SimulatedBench(truth, 3)
    series = [bench.perform(Dwell(p, 10.0)) for p in ALL_POSITIONS]
    soak = bench.perform(Dwell(1, 300.0))
    *parts, soak = (replace(each, extra={"aux_pump": np.sin(each.t / 40)}) for each in (*series, soak))
    dwells = tuple(DwellRecord(f"dwell_{p:02d}", p, each) for p, each in zip(ALL_POSITIONS, parts, strict=True))
    campaign = replace(plain, dwells=dwells, soaks=(SoakRecord("soak", 1, None, soak),))
    return evidence_of(fit([campaign]))


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda each: each.name)
def test_the_columns_of_an_effect(effect: Effect) -> None:
    excitation, told = evidence().excitation, list[object]()
    ways = list(effect.columns(excitation))[:4]
    for way in ways:
        sizes = effect.plausible_of(way)
        added = None if effect.added is None or way is not ways[0] else effect.added(excitation, sizes)
        shown = None if effect.shown is None else effect.shown(sizes, 0.1 * sizes)
        fitted = None if effect.fitted is None or shown is None else effect.fitted(shown[0])
        at = None if effect.at is None else effect.at(excitation, way).accel
        said = [way.coefficients, way.accel, way.gyro, way.unit, way.shape]
        told.append([said, sizes, added, shown, fitted, at])
    assert_held("effects", effect.name, told)


def test_the_rows_that_an_effect_is_sought_in() -> None:
    rows = evidence()
    assert_held(
        "effects",
        "rows",
        {"sigma": rows.sigma, "A": rows.A, "f": rows.excitation.f, "T": rows.excitation.temperature},
    )
