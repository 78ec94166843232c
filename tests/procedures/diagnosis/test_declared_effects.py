"""Which declared effects are one in a design: what adds no more than the other, not the other way round."""

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from procedures.diagnosis.declared_effects import are_one
from procedures.diagnosis.diagnose import diagnose
from procedures.effects.term.effect_of_term import TermEffect
from tests.benchmarks.diagnosing.designs import unit
from tests.procedures.diagnosis.redrawn import made_up, small


def test_what_adds_a_column_more_is_not_one_with_what_lacks_it() -> None:
    rng = np.random.default_rng(3)
    evidence, H = small(rng), rng.standard_normal((36, 2))
    less, more = made_up(evidence, H[:, :1]), made_up(evidence, H)
    assert are_one(evidence, less, more)
    assert not are_one(evidence, more, less)
    assert are_one(evidence, more, made_up(evidence, H @ [[1.0, 2.0], [0.5, -1.0]]))
    assert not are_one(evidence, more, made_up(evidence, rng.standard_normal((36, 2))))


def test_what_the_model_holds_already_is_one_with_nothing() -> None:
    rng = np.random.default_rng(4)
    evidence = small(rng)
    held = made_up(evidence, evidence.A[:, :1])
    assert not are_one(evidence, held, held)


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
