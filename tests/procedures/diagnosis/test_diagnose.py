import json
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import CampaignFits, fit
from procedures.diagnosis.diagnose import diagnose
from procedures.diagnosis.result import Diagnosis, Finding
from station.files.campaign_folder.campaign_reading import read_campaign
from tests.benchmarks.diagnosing.designs import certified, plain, unit
from tests.benchmarks.diagnosing.outside import outside
from tests.paths import DATA

CAMPAIGNS = DATA / "campaigns"
FOLDERS = [CAMPAIGNS / name for name in ("bench_only", "quadratic_free")]
BENCH = ("slab.", "fixture.", "site.", "placement.", "clock.", "disturbance.", "auxiliary.")
LEANING = {"gyroscope.g_sensitivity": {"xy": 0.3, "zx": -0.3}}


def finding_of(found: Diagnosis, name: str) -> Finding:
    return next(finding for finding in found.findings if finding.effect == name)


def is_claimed(finding: Finding) -> bool:
    return finding.kind == "instrument" and finding.confidence != "ambiguous"


def level(seed: int) -> Truth:
    """A unit on a bench without tilts."""
    return replace(unit(seed), faces_rad=np.zeros((6, 2)), slab_tilt_rad=np.zeros(2))


def test_a_clean_unit_on_a_true_bench_is_consistent() -> None:
    seed = 0
    found = diagnose(certified(level(seed), seed))
    assert found.verdict == "consistent"
    assert found.findings == ()
    assert len(found.tried) > 10
    assert all(each.before == each.after for each in found.errors)


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_a_campaign_with_a_planted_effect_is_named_as_it_was_planted(folder: Path) -> None:
    if not folder.is_dir():
        pytest.skip(f"no shared data at {DATA}: set STATION_DATA")
    truth = json.loads((folder / "truth.json").read_text())
    found = diagnose([read_campaign(folder).campaign])
    left_out_groups = [({f.effect, *f.aliases}, f) for f in found.findings]
    assert truth["verdict"] in {None, found.verdict}
    for expected in truth["expect"]:
        if "~" in expected:
            assert any(set(expected.split("~")) <= group for group, _ in left_out_groups), expected
        else:
            assert any(set(expected.split("|")) & group for group, _ in left_out_groups), expected
    wanted = {name for each in truth["expect"] for name in each.replace("~", "|").split("|")}
    for group, finding in left_out_groups:
        is_group = finding.confidence == "ambiguous" and any(name.startswith(BENCH) for name in group)
        assert group & wanted or finding.effect.startswith(BENCH) or is_group, finding.effect


@pytest.mark.parametrize("seed", [11])
def test_a_bad_dwell_is_no_effect_of_the_instrument(seed: int) -> None:
    seated = {"placement.dwell": {"position": 3 + seed % 7, "x": 5e-5, "y": -4e-5, "z": 6e-5}}
    found = diagnose(plain(unit(seed, effects=seated), seed))
    assert not any(is_claimed(finding) for finding in found.findings)
    assert found.verdict != "consistent"


TWO = {"accelerometer.relaxation": {"x": 6e-6, "tau_s": 20.0}, **LEANING}


def test_two_effects_at_once_are_both_named_with_their_sizes() -> None:
    found = diagnose(certified(unit(5, effects=TWO), 5))
    for name in TWO:
        finding = finding_of(found, name)
        assert set(finding.aliases) <= {"gyroscope.magnetic", "accelerometer.bias_drift"}
        sizes = np.array([TWO[name].get(key, 0.0) for key in finding.coefficients])
        if name == "gyroscope.g_sensitivity":
            assert np.max(np.abs(finding.value - sizes) / finding.std) < 4
        else:
            assert finding.value[0] == pytest.approx(6e-6, rel=0.3)


def test_what_is_in_no_catalogue_is_unexplained_and_named_nothing() -> None:
    found = diagnose(plain(unit(8), 8, outside("heading, all", 4e-6)))
    assert found.verdict == "unexplained"
    assert not any(is_claimed(finding) for finding in found.findings)


def gyro_bias(fits: CampaignFits) -> np.ndarray:
    assert fits.gyroscope is not None
    joint = fits.gyroscope.joint
    return joint.b / np.linalg.norm(joint.K, axis=1)


@cache
def leaning(seed: int) -> Diagnosis:
    return diagnose(certified(unit(seed, effects={"gyroscope.g_sensitivity": {"xx": 0.5, "yy": -0.4}}), seed))


def test_the_bias_is_as_good_after_as_that_of_a_clean_unit() -> None:
    before, after, clean = [], [], []
    for seed in (21,):
        truth, found = unit(seed), leaning(seed)
        clean.append(gyro_bias(fit(certified(truth, seed))) - truth.gyro_d_deg_s)
        before.append(gyro_bias(found.before) - truth.gyro_d_deg_s)
        after.append(gyro_bias(found.after) - truth.gyro_d_deg_s)
    rms_before, rms_after, rms_clean = (np.sqrt(np.mean(np.square(each))) for each in (before, after, clean))
    assert rms_after <= 1.5 * rms_clean
    assert rms_before > 1.5 * rms_clean  # the effect did harm


def test_the_error_of_what_was_left_out_falls_where_an_effect_was_found() -> None:
    found = leaning(21)
    errors = next(each for each in found.errors if each.quantity == "gyroscope dwells")
    assert errors.held_out_before is not None
    assert errors.held_out_after is not None
    assert errors.held_out_after < 0.6 * errors.held_out_before
    assert errors.after < 0.6 * errors.before
