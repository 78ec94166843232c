"""A verdict does not lean on dwells that contradict each other by more than a bench does."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from procedures.bench.seating_check import PLAUSIBLE_FACE_TILT_RAD
from station.guide.outcome import verdict_view
from station.results.campaign_results import make_results
from station.results.contradictory_dwells import contradiction_of
from tests.station.campaign_writing import write_campaign
from tests.station.guide.stored import recorded

DOCUMENT: dict[str, Any] = {
    "verdict": "partly",
    "error": [
        {"quantity": "accelerometer dwells", "unit": "g", "before": 1.1 * PLAUSIBLE_FACE_TILT_RAD},
        {"quantity": "gyroscope turns", "unit": "deg", "before": 30.0},
    ],
}


def test_a_tilt_that_no_cube_has_is_said_in_degrees() -> None:
    assert "contradict each other by 0.063 deg" in contradiction_of(DOCUMENT)


@pytest.mark.parametrize("verdict", ["explained", "established", "likely", "nothing"])
def test_a_cause_that_is_known_is_no_contradiction(verdict: str) -> None:
    assert not contradiction_of(DOCUMENT | {"verdict": verdict})


def test_what_a_cube_s_own_faces_may_do_is_none() -> None:
    small = {"quantity": "accelerometer dwells", "unit": "g", "before": 0.9 * PLAUSIBLE_FACE_TILT_RAD}
    assert not contradiction_of(DOCUMENT | {"error": [small]})
    assert not contradiction_of(DOCUMENT | {"error": DOCUMENT["error"][1:]})


def test_seven_dwells_with_one_on_a_crumb_of_a_degree_are_not_to_be_relied_on(tmp_path: Path) -> None:
    """No twelve positions: the model takes the crumb for tilts of slab and faces, and fits."""
    truth = replace(Truth.example(7), effects={"placement.dwell": {"x": -0.02, "z": 0.015, "position": 5.0}})
    with open_db(tmp_path / "station.db") as db:
        folder = recorded(tmp_path / "c", db)
        shutil.rmtree(folder)
        campaign = simulate_campaign(truth, 3, dwell_s=20.0, positions=(1, 3, 5, 6, 7, 10, 12), turns=())
        write_campaign(folder, campaign, truth.sample_period_s)
        results = make_results(folder, db)
        assert verdict_view(results, db).doubt.startswith(
            "do not rely on it: the dwells contradict each other by "
        )
        assert "do not rely on it: the dwells" in results.report_file.read_text()
