"""A verdict does not lean on dwells that contradict each other by more than a bench does."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from fixtures_db.database import Database, open_db
from procedures.bench.seating_check import PLAUSIBLE_FACE_TILT_RAD
from procedures.campaign.campaign import Campaign
from procedures.units import RAD_PER_ARCSEC
from station.guide.outcome import verdict_view
from station.results.campaign_results import CampaignResults, make_results
from station.results.contradictory_dwells import contradiction_of
from tests.station.campaign_writing import write_campaign
from tests.station.guide.stored import recorded

DOCUMENT: dict[str, Any] = {
    "verdict": "partly",
    "findings": [],
    "error": [
        {"quantity": "accelerometer dwells", "unit": "g", "before": 1.1 * PLAUSIBLE_FACE_TILT_RAD},
        {"quantity": "gyroscope turns", "unit": "deg", "before": 30.0},
    ],
}


def of_campaign(folder: Path, db: Database, campaign: Campaign) -> CampaignResults:
    """Solve a campaign in the place of a recorded one."""
    recorded(folder, db)
    shutil.rmtree(folder)
    write_campaign(folder, campaign, Truth.example(7).sample_period_s)
    return make_results(folder, db)


def test_a_tilt_that_no_cube_has_is_said_in_degrees() -> None:
    assert "contradict each other by 0.063 deg" in contradiction_of(DOCUMENT)


@pytest.mark.parametrize("verdict", ["explained", "established", "likely", "nothing"])
def test_a_cause_that_is_known_is_no_contradiction(verdict: str) -> None:
    assert not contradiction_of(DOCUMENT | {"verdict": verdict})


def test_what_a_cube_s_own_faces_may_do_is_none() -> None:
    small = {"quantity": "accelerometer dwells", "unit": "g", "before": 0.9 * PLAUSIBLE_FACE_TILT_RAD}
    assert not contradiction_of(DOCUMENT | {"error": [small]})
    assert not contradiction_of(DOCUMENT | {"error": DOCUMENT["error"][1:]})


LEFT = {
    "verdict": "unexplained",
    "findings": [],
    "error": [],
    "left": [
        {"by": "rows", "what": "gyroscope mean", "size": 60.0, "log10_p": -900.0},
        {"by": "step", "what": "dwell_05.mcap", "size": 4.9, "log10_p": -80.0},
        {"by": "step", "what": "dwell_07.mcap", "size": 26.0, "log10_p": -70.0},
    ],
}


@pytest.mark.parametrize("verdict", ["unexplained", "partly"])
def test_a_step_far_beyond_its_noise_for_no_known_cause_is_named(verdict: str) -> None:
    said = contradiction_of(LEFT | {"verdict": verdict}, is_certified=True)
    assert said.startswith("do not rely on it: dwell_07.mcap is 26 times farther off than its noise")


@pytest.mark.parametrize("verdict", ["consistent", "established", "likely", "ambiguous"])
def test_it_is_not_where_a_cause_is_known(verdict: str) -> None:
    assert not contradiction_of(LEFT | {"verdict": verdict})


def test_scatter_of_all_steps_is_in_the_uncertainty_and_no_step_is_named() -> None:
    assert not contradiction_of(LEFT | {"left": LEFT["left"][:2]})


def test_seven_dwells_with_one_on_a_crumb_of_a_degree_are_not_to_be_relied_on(tmp_path: Path) -> None:
    """No twelve positions: the model takes the crumb for tilts of slab and faces, and fits."""
    truth = replace(Truth.example(7), effects={"placement.dwell": {"x": -0.02, "z": 0.015, "position": 5.0}})
    with open_db(tmp_path / "station.db") as db:
        campaign = simulate_campaign(truth, 3, dwell_s=20.0, positions=(1, 3, 5, 6, 7, 10, 12), turns=())
        results = of_campaign(tmp_path / "c", db, campaign)
        assert verdict_view(results, db).doubt.startswith(
            "do not rely on it: the dwells contradict each other by "
        )
        assert "do not rely on it: the dwells" in results.report_file.read_text()


def test_a_seat_that_only_its_size_keeps_out_is_one() -> None:
    seat = {"effect": "placement.dwell", "times_plausible": 5.7}
    small = {"quantity": "accelerometer dwells", "unit": "g", "before": 0.6 * PLAUSIBLE_FACE_TILT_RAD}
    document = {"verdict": "unexplained", "error": [small], "findings": [], "too_large": [seat]}
    assert "contradict each other by 0.034 deg" in contradiction_of(document)
    other = {"effect": "accelerometer.quadratic", "times_plausible": 9.0}
    assert not contradiction_of(document | {"too_large": [other, seat]})
    assert not contradiction_of(document | {"too_large": []})


def faces_off(*aliases: str, **more: Any) -> dict[str, Any]:
    finding = {
        "effect": "fixture.parallelism", "confidence": "ambiguous", "aliases": list(aliases), "where": {},
        "coefficients": {"x.y": {"value": 1e-6}, "y.z": {"value": -1e-4}},
    }  # fmt: skip
    return {"verdict": "ambiguous", "error": [], "findings": [finding | more]}


def test_faces_off_their_certificate_may_be_a_seat_that_is_off() -> None:
    said = contradiction_of(faces_off("fixture.face_tilt", "placement.dwell"), is_certified=True)
    assert said.startswith(
        "do not rely on it: the dwells contradict the certificate of the cube's faces by 21 arcsec"
    )
    alike = faces_off("placement.dwell", "accelerometer.quadratic", where={"channel": ["ay"]})
    assert "by 21 arcsec" in contradiction_of(alike, is_certified=True)


def test_faces_without_certificate_may_be_off_and_so_may_those_that_are_told() -> None:
    assert not contradiction_of(faces_off("placement.dwell"), is_certified=False)
    told = faces_off(confidence="established") | {"verdict": "partly"}
    assert not contradiction_of(told, is_certified=True)


def test_what_may_be_a_sensor_s_alone_is_no_contradiction() -> None:
    assert not contradiction_of(faces_off("accelerometer.quadratic", "placement.dwell"), is_certified=True)
    slab = faces_off("placement.dwell", effect="slab.tilt")
    assert not contradiction_of(slab, is_certified=True)


def test_a_crumb_under_a_face_that_stood_once_contradicts_the_certificate(tmp_path: Path) -> None:
    """22 arcsec of it: by what the model makes of them a misalignment is ten of its sigmas off."""
    truth = replace(Truth.example(7), effects={"placement.dwell": {"x": 22 * RAD_PER_ARCSEC, "position": 7.0}})
    positions = (1, 3, 4, 5, 7, 9, 10, 11, 12)
    with open_db(tmp_path / "station.db") as db:
        campaign = simulate_campaign(
            truth, 3, dwell_s=8.0, positions=positions, turns=(), certificate_sigma=RAD_PER_ARCSEC
        )
        results = of_campaign(tmp_path / "c", db, campaign)
        assert "contradict the certificate of the cube's faces" in verdict_view(results, db).doubt


def face_tilted(value: float, std: float, *aliases: str) -> dict[str, Any]:
    tilt = {
        "effect": "fixture.face_tilt", "confidence": "ambiguous", "where": {},
        "aliases": ["accelerometer.quadratic", *aliases],
        "coefficients": {"y_up.x": {"value": -value, "std": std}, "x_up.z": {"value": 1e-5, "std": std}},
    }  # fmt: skip
    return {"verdict": "ambiguous", "error": [], "findings": [tilt]}


def test_faces_tilted_as_no_face_is_may_be_seats_that_are_off() -> None:
    """Two cubes askew about the vertical, each alone on its face: faces tilted by 0.3 deg fit them."""
    large = 2.7 * PLAUSIBLE_FACE_TILT_RAD
    said = contradiction_of(face_tilted(large, large / 6, "placement.dwell"))
    assert "contradict each other by 0.15 deg" in said
    perhaps_small = face_tilted(large, large / 2.5, "placement.dwell")
    assert not contradiction_of(perhaps_small)
    assert contradiction_of(face_tilted(large, large / 6))
    sure = face_tilted(large, large / 6) | {"verdict": "established"}
    assert "contradict each other by 0.15 deg" in contradiction_of(sure)
    assert not contradiction_of(face_tilted(large, large / 2.5) | {"verdict": "established"})
