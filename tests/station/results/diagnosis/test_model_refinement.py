"""The loop is closed: the calibration has the effects in, and counts at another temperature come out right."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import report
from procedures.diagnosis.diagnose import diagnose
from procedures.units import STANDARD_GRAVITY
from station.calibrated.applied_calibration import calibrated_inputs
from station.calibrated.correction_inputs import Surroundings
from station.files.campaign_folder.campaign_reading import read_for_solve
from station.results.diagnosis import model_refinement
from station.results.diagnosis.model_refinement import refine_model
from station.results.result_formats import document_of
from station.results.solution_json import solution_document
from tests.station.results.diagnosis.conftest import Diagnosed, simulated
from tests.stored.small_campaigns import CASES, campaigns_of, some_effects


def test_counts_at_another_temperature_come_out_right(warmed: Diagnosed) -> None:
    loaded = read_for_solve([warmed.folder])
    closed = refine_model(loaded)
    assert [effect["name"] for effect in closed.effects] == ["accelerometer.bias_temperature"]
    assert closed.effects[0]["reference"] == {"temperature_c": 25.0}
    planted = {"accelerometer.bias_temperature": {"x": 8e-5, "y": -5e-5, "z": 9e-5}}
    truth = replace(Truth.example(7), temperature_start_c=38.0, effects=planted, sample_period_s=0.05)
    dwell = simulate_campaign(truth, 9, positions=(9,), dwell_s=60.0, turns=()).dwells[0].series  # z up
    assert dwell.accel is not None
    rate = dwell.accel.mean(axis=0, keepdims=True) / dwell.period
    around = Surroundings(temperature=dwell.temperature.mean(keepdims=True))
    calibration = {**document_of(solution_document(closed.solution, loaded)), "effects": closed.effects}
    up = truth.local_gravity / STANDARD_GRAVITY
    f = calibrated_inputs(calibration, rate, None, around).f
    assert f is not None
    assert abs(f[0, 2] - up) < 8e-5  # the average over models holds a tenth of a coefficient of dT/dt
    without = calibrated_inputs({**calibration, "effects": []}, rate, None, around).f
    assert without is not None
    assert abs(without[0, 2] - up) > 1e-3


def test_an_instrument_effect_that_is_ambiguous_is_not_carried(
    warmed: Diagnosed, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = model_refinement.diagnose([one.campaign for one in read_for_solve([warmed.folder])])
    unsure = tuple(replace(each, probability=0.6) for each in found.findings)
    monkeypatch.setattr(model_refinement, "diagnose", lambda campaigns, declared: replace(found, findings=unsure))
    closed = refine_model(read_for_solve([warmed.folder]))
    assert closed.effects == ()
    assert closed.solution is found.solution_before
    assert not np.allclose(closed.solution.covariance, found.solution.covariance)


@pytest.mark.proof
def test_in_the_dwell_that_is_left_of_a_face_debris_is_reported_not_to_show(tmp_path: Path) -> None:
    off = {"placement.dwell": {"position": 7.0, "x": 6e-4, "z": -3e-4}}
    (loaded,) = read_for_solve([simulated(tmp_path, off, 4, moves=True)])
    certified = refine_model([loaded])  # the certificate of the faces tells a crumb
    assert not [text for text in certified.solution.warnings if "debris under" in text]
    fixture = replace(loaded.campaign.fixture, faces={})
    found = refine_model([replace(loaded, campaign=replace(loaded.campaign, fixture=fixture))])
    assert "placement.dwell" in [each.effect for each in found.diagnosis.findings]
    (reported,) = (text for text in found.solution.warnings if "debris under" in text)
    assert "8 (" in reported
    assert "7 (" not in reported
    assert 7 not in {each.position for each in found.solution.undetectable_tilts}
    assert any("debris under" in text for text in found.document["solution"]["warnings"])


def test_what_the_diagnosis_left_unexplained_is_in_the_uncertainty() -> None:
    case = CASES["wandering"]
    found = diagnose(campaigns_of(case), some_effects(*case.tried))
    assert found.verdict == "unexplained"
    closed = model_refinement.ModelRefinement(found, {}, found.before, report(found.before), ())
    sources = {part.source for each in closed.budgets() for part in each.contributions}
    assert "unexplained" in sources
