"""Which declared effects are one in a design: what adds no more than the other, not the other way round."""

import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from procedures.diagnosis.diagnose import diagnose
from procedures.effects.term.effect_of_term import TermEffect
from tests.benchmarks.diagnosing.designs import unit


def test_an_effect_that_nobody_declared_is_found_beside_one_that_somebody_did() -> None:
    """The declared one, quadratic, is a parameter of the model; what that lacks is a finding with its size."""
    planted = {"accelerometer.quadratic": {"x": 8e-5}, "gyroscope.g_sensitivity": {"xy": 0.8, "zz": -0.5}}
    campaign = simulate_campaign(unit(2, effects=planted), 2, certificate_sigma=5e-6, draw_stated=False)
    term = TermEffect("accelerometer.quadratic", "accelerometer", ("u**2",), "g/g^2", 1e-4, "")
    found = diagnose([campaign], declared=[term])
    (finding,) = (each for each in found.findings if each.effect == "gyroscope.g_sensitivity")
    assert "accelerometer.quadratic" not in [each.effect for each in found.findings]
    sizes = dict(zip(finding.coefficients, finding.value, strict=True))
    std = dict(zip(finding.coefficients, finding.std, strict=True))
    assert abs(sizes["xy"] - 0.8) < 4 * std["xy"]
    assert abs(sizes["zz"] + 0.5) < 4 * std["zz"]
    (declared,) = found.declared
    assert declared.value[0] == pytest.approx(8e-5, abs=4 * declared.std[0])
