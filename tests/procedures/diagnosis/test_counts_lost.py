"""Counts lost above a rate are told from a smooth nonlinearity by turns at several speeds."""

from collections.abc import Mapping

from drivers.simulated.bench_in_memory import simulate_campaign
from procedures.campaign.campaign import Campaign
from procedures.campaign.plan_steps import Turn
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis, Finding
from procedures.frames import TURN_START
from tests.benchmarks.diagnosing.designs import unit

SPEEDS = (10.0, 25.0, 50.0, 90.0)  # deg/s
KNEE = 35.0  # deg/s
NAME = "gyroscope.counts_lost"


def turned(seed: int, effects: Mapping[str, dict[str, float]]) -> Campaign:
    """Return twelve positions and turns at four speeds."""
    turns = [Turn(axis, way, 3, TURN_START[axis], 2.0, v) for axis in "xyz" for way in "+-" for v in SPEEDS]
    return simulate_campaign(unit(seed, effects=effects), seed, draw_stated=False, turns=tuple(turns))


def of_gyroscopes(found: Diagnosis) -> list[Finding]:
    return [each for each in found.findings if each.effect.startswith("gyroscope.")]


def test_lost_counts_are_named_with_their_share_and_knee() -> None:
    lost = {"x": 800.0, "y": 0.0, "z": 500.0, "knee_deg_s": KNEE}
    (finding,) = of_gyroscopes(diagnose([turned(1, {NAME: lost})]))
    assert finding.effect == NAME
    for name, value, std in zip(finding.coefficients, finding.value, finding.std, strict=True):
        assert abs(value - lost[name]) < 4 * std, name
