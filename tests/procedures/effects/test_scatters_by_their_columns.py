"""Scatters of headings, closures and seats against the simulator's hands: a draw a step, of the size planted."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from procedures.arrays import FloatArray
from procedures.calibration.joint_calibration import fit_reduced
from procedures.calibration.reduced_steps import reduce_steps
from procedures.campaign.campaign import ProcedureSigma
from procedures.campaign.plan_steps import turn_steps
from procedures.effects import EFFECTS
from procedures.evidence.residual_rows import Evidence, evidence_of
from tests.procedures.effects.test_every_effect import UNIT

BY_NAME = {effect.name: effect for effect in EFFECTS}
K = {"mean": (UNIT.accel_k, UNIT.gyro_k), "turn": (None, UNIT.gyro_k)}


def carried_out(effects: dict[str, dict[str, float]]) -> tuple[Evidence, list[FloatArray]]:
    """Return a campaign's evidence, and the rates and totals behind its means and turns [g, deg/s; deg]."""
    quiet = {"heading_std_deg": 0.0, "closure_std_deg": 0.0, "accel_noise_g": 1e-9, "gyro_arw_deg_rt_s": 1e-9}
    truth = replace(UNIT, effects=effects, temperature_rise_k=0.0, **quiet)
    made = simulate_campaign(truth, 1, dwell_s=12.0, turns=turn_steps(1, 2.0), draw_stated=False, move_s=20.0)
    steps = reduce_steps([replace(made, sigma=ProcedureSigma(1e-3, 2e-4))])
    seen = [steps.accel.rate / UNIT.accel_k, steps.gyro.rate / UNIT.gyro_k]
    return evidence_of(fit_reduced(steps)), [*seen, np.array([t.total for t in steps.turns]) / UNIT.gyro_k]


@pytest.mark.parametrize(
    ("name", "size", "steps"),
    [("placement.scatter", 1e-4, 36), ("procedure.closure", 0.05, 6), ("procedure.heading", 0.3, 12)],
)
def test_a_planted_scatter_is_draws_along_its_columns(name: str, size: float, steps: int) -> None:
    evidence, before = carried_out({})
    _, after = carried_out({name: {"value": size}})
    changed = [b - a for a, b in zip(before, after, strict=True)]
    (way,) = BY_NAME[name].columns(evidence.excitation)
    H = evidence.column(way)
    rows = [
        evidence.rows("mean", triad="accelerometer"),
        evidence.rows("mean", triad="gyroscope"),
        evidence.rows("turn"),
    ]
    reported = {"placement.scatter": 0, "procedure.closure": 2, "procedure.heading": 1}[name]
    along, got = H[rows[reported]], changed[reported].ravel()
    c, *_ = np.linalg.lstsq(along, got, rcond=None)
    assert np.linalg.norm(got - along @ c) < 0.05 * np.linalg.norm(got)
    assert len(c) == steps
    assert 0.4 * size < np.sqrt(np.mean(c**2)) < 1.7 * size
