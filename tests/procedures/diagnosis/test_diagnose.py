"""Whole campaigns with a planted cause: it is named with its size, and nothing else is."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.calibration.joint_calibration import CampaignFits, fit
from procedures.diagnosis.diagnose import diagnose
from procedures.effects.term.effect_of_term import TermEffect
from procedures.inference.result import Diagnosis, Finding
from station.files.campaign_folder.campaign_reading import read_campaign
from tests.benchmarks.diagnosing.designs import WARM, certified, plain, repeated, two_sites, two_speeds, unit
from tests.benchmarks.diagnosing.outside import outside
from tests.benchmarks.undeclared_kinds.literature import LITERATURE
from tests.paths import DATA

TILTED = {"gyroscope.g_sensitivity": {"xy": 0.3, "zx": -0.3}}


def finding_of(found: Diagnosis, name: str) -> Finding:
    return next(finding for finding in found.findings if finding.effect == name)


def is_claimed(finding: Finding) -> bool:
    return finding.kind == "instrument" and finding.confidence != "possible"


def level(seed: int) -> Truth:
    """A unit on a bench without tilts."""
    return replace(unit(seed), faces_rad=np.zeros((6, 2)), slab_tilt_rad=np.zeros(2))


def test_a_clean_unit_on_a_true_bench_is_consistent() -> None:
    found = diagnose(certified(level(0), 0))
    assert found.verdict == "consistent"
    assert found.findings == ()
    assert len(found.probabilities) > 10
    assert all(each.before == each.after for each in found.errors)


def test_a_recorded_campaign_of_a_faulty_bench_names_the_bench_alone() -> None:
    folder = DATA / "campaigns/bench_only"
    if not folder.is_dir():
        pytest.skip(f"no shared data at {DATA}: set STATION_DATA")
    found = diagnose([read_campaign(folder).campaign])
    assert not any(is_claimed(each) for each in found.findings)
    assert found.verdict == "consistent"  # slab and faces are parameters of the model
    sigma = np.sqrt(np.diag(found.solution.covariance))
    tilts = [i for i, name in enumerate(found.solution.names) if name.startswith(("slab", "fixture"))]
    assert tilts
    assert np.isfinite(sigma[tilts]).all()


TWO = {"accelerometer.relaxation": {"x": 6e-6, "tau_s": 20.0}, **TILTED}


def test_two_effects_at_once_are_both_named_with_their_sizes() -> None:
    found = diagnose(certified(unit(5, effects=TWO), 5))
    for name in TWO:
        finding = finding_of(found, name)
        assert all(alias.startswith("a function of") for alias in finding.aliases)
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
def tilted(seed: int) -> Diagnosis:
    return diagnose(certified(unit(seed, effects={"gyroscope.g_sensitivity": {"xx": 0.5, "yy": -0.4}}), seed))


def test_the_bias_is_as_good_after_as_that_of_a_clean_unit() -> None:
    before, after, clean = [], [], []
    for seed in (21,):
        truth, found = unit(seed), tilted(seed)
        clean.append(gyro_bias(fit(certified(truth, seed))) - truth.gyro_d_deg_s)
        before.append(gyro_bias(found.before) - truth.gyro_d_deg_s)
        after.append(gyro_bias(found.after) - truth.gyro_d_deg_s)
    rms_before, rms_after, rms_clean = (np.sqrt(np.mean(np.square(each))) for each in (before, after, clean))
    assert rms_after <= 1.5 * rms_clean
    assert rms_before > 1.5 * rms_clean  # the effect did harm


def test_the_error_of_what_was_left_out_falls_where_an_effect_was_found() -> None:
    found = tilted(21)
    errors = next(each for each in found.errors if each.quantity == "gyroscope dwells")
    assert errors.held_out_before is not None
    assert errors.held_out_after is not None
    assert errors.held_out_after < 0.6 * errors.held_out_before
    assert errors.after < 0.6 * errors.before


# A wrong latitude and a jump of a bias are not taken for an error term of the instrument


@pytest.mark.parametrize(("seed", "off_deg"), [(5, -0.35)])
def test_a_latitude_that_is_wrong_is_no_magnetic_sensitivity(seed: int, off_deg: float) -> None:
    off = float(np.radians(off_deg))
    found = diagnose(plain(unit(seed, effects={"site.latitude": {"value": off}}), seed))
    (site,) = (each for each in found.findings if each.effect == "site.latitude")
    assert abs(site.value[0] - off) < 4 * site.std[0]
    assert not [each.effect for each in found.findings if each.effect.startswith("gyroscope")]


def test_a_jump_while_the_cube_rests_is_found_within_its_dwell() -> None:
    """Taken for one between two dwells it left half of itself in that dwell, and the name with it."""
    jumped = {"accelerometer.jump": {"y": 8.08e-6, "after_s": 681.0}}  # dwell_05 is from 625.1 to 725.1 s
    found = diagnose(repeated(unit(570_002, effects=jumped), 570_002))
    (jump,) = (each for each in found.findings if each.kind == "instrument")
    assert (jump.effect, jump.confidence, jump.where["in"]) == ("accelerometer.jump", "established", "dwell_05")
    assert abs(float(str(jump.where["after_s"])) - 55.9) < 100 / 16
    assert jump.coefficients == ("y",)
    assert abs(jump.value[0] - 8.08e-6) < 4 * jump.std[0]
    assert found.log_p > np.log(0.01)


# Error terms that the user declared, next to one that nobody declared


def test_an_effect_that_nobody_declared_is_found_with_one_that_somebody_did() -> None:
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


K2 = {"accelerometer.quadratic": {"x": 4e-5}}  # 27 sigma under the certificate


@cache
def quadratic() -> Finding:
    findings = diagnose(certified(unit(7, effects=K2), 7)).findings
    return next(f for f in findings if "accelerometer.quadratic" in (f.effect, *f.aliases))


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.proof)])
def test_a_gravity_error_has_the_sign_of_the_campaign_that_is_named(seed: int) -> None:
    size = 1.5e-4  # m/s^2, at the second site; at the first it is as much the other way round
    found = diagnose(two_sites(unit(seed, effects={"site.gravity": {"value": size}}), seed))
    gravity = next(each for each in found.findings if each.effect == "site.gravity")
    expected = size if gravity.where["campaign"] == 2 else -size
    assert abs(gravity.value[0] - expected) < 4 * gravity.std[0]
    assert abs(gravity.value[0]) > 5 * gravity.std[0]


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.proof)])
def test_a_unit_that_slips_in_its_fixture_is_a_tilt_and_no_scatter(seed: int) -> None:
    found = diagnose(LITERATURE["unit slips in the fixture"].campaigns(seed))
    (tilt,) = found.findings
    assert tilt.effect == "placement.tilt"
    assert tilt.probability > 0.99
    assert "after" in tilt.where
    assert 1e-5 < np.linalg.norm(tilt.value) < 5e-4
    assert np.linalg.norm(tilt.value) > 10 * np.max(tilt.std)


def test_certified_quadratic_is_not_its_faces_though_they_look_alike() -> None:
    finding = quadratic()
    assert finding.effect == "accelerometer.quadratic"
    alike = [finding.shares[name] for name in ("accelerometer.quadratic", "accelerometer.scale_asymmetry")]
    assert sum(alike) > 0.9
    assert abs(finding.value[0] / finding.std[0]) > 15
    assert abs(finding.value[0] - 4e-5) < 4 * finding.std[0]


def test_uncertified_quadratic_is_not_separable_and_says_what_separates_it() -> None:
    found = diagnose(plain(unit(7, effects=K2), 7))
    assert "free positions" in found.not_separable["accelerometer.quadratic"]
    assert not any(is_claimed(each) for each in found.findings)


# A known cause next to an unknown one: the first is named with its share, the rest is reported as unexplained


HEATED = {"accelerometer.bias_temperature": {"x": 15e-6, "y": -10e-6, "z": 20e-6}}


def test_what_is_known_is_named_and_what_is_left_is_shown() -> None:
    truth = unit(7, **WARM, effects=HEATED)
    found = diagnose(plain(truth, 7, outside("heading, accelerometers", 4e-6)))
    assert found.verdict == "partly"
    (known,) = (each for each in found.findings if each.effect == "accelerometer.bias_temperature")
    assert known.share > 0.9
    assert abs(known.value[0] - 15e-6) < 5 * known.std[0] + 2e-6  # what is left is in no sigma of a coefficient
    assert found.left[0].what == "accelerometer mean"
    assert all(each.share == 0.0 for each in found.findings if each.effect.startswith(("slab", "fixture")))
    assert found.unexplained_before is not None


# Scatter of seating, heading and closure is named as such, not as an error of the instrument


SCATTERS = ("placement.scatter", "procedure.closure", "procedure.heading")


def instrument_findings(diagnosis: Diagnosis) -> list[Finding]:
    return [each for each in diagnosis.findings if each.kind == "instrument"]


def test_seats_that_scatter_are_named_with_their_size() -> None:
    name, size = "placement.scatter", 3e-5
    diagnosis = diagnose(plain(unit(3, effects={name: {"value": size}}), 3))
    (scatter,) = (each for each in diagnosis.findings if each.effect in SCATTERS)
    assert (scatter.effect, scatter.kind) == (name, "procedure")
    assert abs(scatter.value[0] - size) < 4 * scatter.std[0]
    assert not instrument_findings(diagnosis)


def test_six_turns_that_close_worse_are_a_group_led_by_the_closure_and_widen_the_sigma() -> None:
    truth = unit(3, effects={"procedure.closure": {"value": 0.08}})
    diagnosis = diagnose(plain(truth, 3))
    (closure,) = (each for each in diagnosis.findings if each.effect in SCATTERS)
    assert closure.effect == "procedure.closure"
    assert "three times the revolutions" in closure.separate_by
    assert not instrument_findings(diagnosis)
    std = [s.gyroscope.scale_factor.std for s in (diagnosis.solution_before, diagnosis.solution)]
    assert np.all(std[1] > 2.0 * std[0])
    assert np.all(np.abs(diagnosis.solution.gyroscope.scale_factor.value - truth.gyro_k) < 4 * std[1])


def test_an_asymmetry_that_two_speeds_show_is_no_closure() -> None:
    truth = unit(4, effects={"gyroscope.scale_asymmetry": {"y": 150.0}})
    (asymmetry,) = instrument_findings(diagnose(two_speeds(truth, 4)))
    assert (asymmetry.effect, asymmetry.confidence) == ("gyroscope.scale_asymmetry", "established")
