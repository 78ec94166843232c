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
from station.guide.campaign.verdict import verdict_view
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


def faces_off(*aliases: str, **more: Any) -> dict[str, Any]:
    finding = {
        "effect": "fixture.parallelism", "confidence": "possible", "aliases": list(aliases), "where": {},
        "coefficients": {"x.y": {"value": 1e-6}, "y.z": {"value": -1e-4}},
    }  # fmt: skip
    return {"verdict": "ambiguous", "error": [], "findings": [finding | more]}


def face_tilted(value: float, std: float, *aliases: str) -> dict[str, Any]:
    tilt = {
        "effect": "fixture.face_tilt", "confidence": "possible", "where": {},
        "aliases": ["accelerometer.quadratic", *aliases],
        "coefficients": {"y_up.x": {"value": -value, "std": std}, "x_up.z": {"value": 1e-5, "std": std}},
    }  # fmt: skip
    return {"verdict": "ambiguous", "error": [], "findings": [tilt]}


def seat_off(value: float, std: float) -> dict[str, Any]:
    seat = {"effect": "placement.dwell", "confidence": "established", "where": {}, "aliases": []}
    coefficients = {"x": {"value": value, "std": std}, "y": {"value": 1e-5, "std": std}}
    return {"verdict": "established", "error": [], "findings": [seat | {"coefficients": coefficients}]}


SMALL = {"quantity": "accelerometer dwells", "unit": "g", "before": 0.6 * PLAUSIBLE_FACE_TILT_RAD}
HIDDEN = {"verdict": "unexplained", "error": [SMALL], "findings": []}
LARGE, SURE = 2.7 * PLAUSIBLE_FACE_TILT_RAD, {"verdict": "established"}
QUADRATIC = "accelerometer.quadratic"


@pytest.mark.parametrize(
    ("document", "is_certified", "reported"),
    [
        (DOCUMENT, False, "0.063 deg"), *((DOCUMENT | {"verdict": known}, False, "") for known in
        ("explained", "established", "likely", "nothing")), (DOCUMENT | {"error": [SMALL]}, False, ""),
        (DOCUMENT | {"error": DOCUMENT["error"][1:]}, False, ""),
        (LEFT, True, "dwell_07.mcap is 26 times"),
        (LEFT | {"verdict": "partly"}, True, "dwell_07.mcap is 26 times"),
        (HIDDEN, False, ""),
        (seat_off(LARGE, LARGE / 6), False, "0.15 deg"),
        (seat_off(LARGE, LARGE / 2.5), False, ""),
        (faces_off("fixture.face_tilt", "placement.dwell"), True, "21 arcsec"),
        (faces_off("placement.dwell", QUADRATIC, where={"channel": ["ay"]}), True, "21 arcsec"),
        (faces_off(QUADRATIC, "placement.dwell"), True, ""),
        (faces_off("placement.dwell", effect="slab.tilt"), True, ""),
        # two cubes askew about the vertical, each alone on its face: faces tilted by 0.3 deg fit them
        (face_tilted(LARGE, LARGE / 6, "placement.dwell"), False, "0.15 deg"),
        (face_tilted(LARGE, LARGE / 2.5, "placement.dwell"), False, ""),
        (face_tilted(LARGE, LARGE / 6), False, "0.15 deg"),
        (face_tilted(LARGE, LARGE / 6) | SURE, False, "0.15 deg"),
        (face_tilted(LARGE, LARGE / 2.5) | SURE, False, ""),
    ],
)  # fmt: skip
def test_what_no_bench_does_is_a_contradiction_and_a_known_cause_or_a_small_one_none(
    document: dict[str, Any], is_certified: bool, reported: str
) -> None:
    found = contradiction_of(document, is_certified=is_certified)
    assert (reported in found) if reported else found == ""


def test_seven_dwells_with_one_tilted_a_degree_by_debris_are_not_to_be_relied_on(tmp_path: Path) -> None:
    """No twelve positions: the model takes the crumb for tilts of slab and faces, and fits."""
    truth = replace(Truth.example(7), effects={"placement.dwell": {"x": -0.02, "z": 0.015, "position": 5.0}})
    with open_db(tmp_path / "station.db") as db:
        campaign = simulate_campaign(truth, 3, dwell_s=20.0, positions=(1, 3, 5, 6, 7, 10, 12), turns=())
        results = of_campaign(tmp_path / "c", db, campaign)
        assert verdict_view(results, db).doubt.startswith(
            "do not use this result: the dwells contradict each other by "
        )
        assert "do not use this result: the dwells" in results.report_file.read_text()


def test_debris_under_a_face_that_stood_once_contradicts_the_certificate(tmp_path: Path) -> None:
    """22 arcsec of it: by what the model makes of them a misalignment is ten of its sigmas off."""
    truth = replace(Truth.example(7), effects={"placement.dwell": {"x": 22 * RAD_PER_ARCSEC, "position": 7.0}})
    positions = (1, 3, 4, 5, 7, 9, 10, 11, 12)
    with open_db(tmp_path / "station.db") as db:
        campaign = simulate_campaign(
            truth, 3, dwell_s=8.0, positions=positions, turns=(), certificate_sigma=RAD_PER_ARCSEC
        )
        results = of_campaign(tmp_path / "c", db, campaign)
        assert "disagree with the face certificate" in verdict_view(results, db).doubt
