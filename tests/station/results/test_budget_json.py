import json
from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import fit
from procedures.uncertainty.budget import budget
from station.results.budget_json import budget_document


def test_budget_1_holds_every_parameter_and_its_contributions_and_no_infinity() -> None:
    budgets = budget(fit([simulate_campaign(Truth.example(2), 2, dwell_s=10.0)]))
    document = json.loads(json.dumps(budget_document(budgets), allow_nan=False))
    assert (document["format"], document["coverage"]) == ("budget/1", 0.95)
    assert len(document["parameters"]) == 24
    for one in document["parameters"]:
        assert one["std"] ** 2 == pytest.approx(sum(part["std"] ** 2 for part in one["contributions"]))
        assert one["expanded"] == pytest.approx(one["coverage_factor"] * one["std"])
        assert all(part["std"] > 0 for part in one["contributions"])
        assert {part["type"] for part in one["contributions"]} <= {"A", "B"}
    (gravity,) = [p for p in document["parameters"][0]["contributions"] if p["source"] == "gravity"]
    assert "dof" not in gravity
    assert gravity["std"] == pytest.approx(document["parameters"][0]["value"] * 1e-5 / 9.80665, rel=1e-2)


def test_a_parameter_that_is_not_finite_is_left_out() -> None:
    budgets = budget(fit([simulate_campaign(Truth.example(2), 2, dwell_s=10.0)]))
    broken = [replace(budgets[0], std=float(np.nan)), *budgets[1:]]
    assert len(budget_document(broken)["parameters"]) == 23
