"""The verdict: every limit counts, what was not measured is never passed, and the sentence says why."""

from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import pytest

from fixtures_db.hash_chain import GENESIS
from fixtures_db.imu_models import Limit, each_axis
from fixtures_db.stored_calibrations import calibration_document
from procedures.positions import FACES, face_normal, face_of
from procedures.twelve_positions.accelerometer_fit import is_determined
from procedures.uncertainty.budget import combined_budget
from procedures.uncertainty.sources import HEADING, SourceCell
from station.guide.campaign.checklist import why_not_solvable
from station.guide.campaign.verdict import change_in_words, verdict_rows
from station.guide.view import StepView
from station.results.parameters_by_name import applied, parameters, shifts
from station.results.verdict import VerdictWord, judge, judged_in_words
from tests.fixtures_db.factory import facts, solution

BIAS = Limit("accelerometer.bias.y", -2.5e-3, 2.5e-3, "g")  # the value is 2e-3, sigma 8e-8
GYRO = Limit("gyroscope.bias.x", -1.0, 1.0, "deg/h")


def document(bias: float = 1e-3) -> dict[str, Any]:
    """Return an accelerometer alone: bias (bias, 2e-3, 1e-3) g, sigma 8e-8."""
    return calibration_document(solution(bias), facts(), GENESIS)


@pytest.mark.parametrize(
    ("limits", "word", "reported"),
    [
        ([BIAS], "PASS", "accelerometer bias y, which uses 80 %"),
        ([Limit("accelerometer.bias.y", None, 2e-3, "g")], "PASS", "100 %"),
        ([Limit("accelerometer.bias.y", None, 2e-3, "g", 1.0)], "FAIL", "2000 ug, minus 1 u"),
        ([BIAS, GYRO], "NOT_MEASURED", "1 of 2"),
        ([Limit("accelerometer.scale_factor.x", 0.0, 9e9, "output/g")], "NOT_MEASURED", "1 of 1"),
        ([], "NOT_MEASURED", "FOG-3"),
        (
            [
                *each_axis(Limit("accelerometer.bias", -0.9e-3, 0.9e-3, "g")),
                Limit("gyroscope.bias.x", 0, 1, "deg/h"),
            ],
            "FAIL",
            "accelerometer bias y, 2000.000 ug; limit +-900 ug",
        ),
    ],
)
def test_the_verdict_and_its_reason(limits: list[Limit], word: VerdictWord, reported: str) -> None:
    outcome = judge(document(), limits)
    assert outcome.word == word
    assert reported in outcome.reason
    assert outcome.sentence.startswith(f"{word.replace('_', ' ') if limits else 'NO LIMITS'}: ")
    assert outcome.exit_code == (word == "FAIL")


@pytest.mark.parametrize("guard", [0.0, 1.64, 3.0])
@pytest.mark.parametrize("sigmas", [-1.0, 1.0])
def test_a_value_is_accepted_up_to_the_guarded_limit(guard: float, sigmas: float) -> None:
    value, sigma = 2e-3, 8e-8
    limit = Limit("accelerometer.bias.y", None, value + (guard + sigmas) * sigma, "g", guard)
    assert judge(document(), [limit]).word == ("PASS" if sigmas > 0 else "FAIL")
    limit = Limit("accelerometer.bias.y", value - (guard + sigmas) * sigma, None, "g", guard)
    assert judge(document(), [limit]).word == ("PASS" if sigmas > 0 else "FAIL")


def test_the_change_is_in_sigmas_of_both_calibrations() -> None:
    before, now = document(1e-3), document(1e-3 + 4 * np.sqrt(2) * 8e-8)
    moved = shifts(applied(parameters(now)), parameters(before))
    assert moved["accelerometer.bias.x"].sigmas == pytest.approx(4.0)
    assert sum(one.sigmas != 0 for one in moved.values()) == 1
    text = change_in_words(moved, before)
    assert "since the calibration of 2026-03-04, 1 of 12 parameters changed by more than 3 u" in text
    assert text.endswith("accelerometer bias x, +0.453 ug (4.0 u)")
    assert change_in_words({}, None) == "this is the first calibration of this unit"
    assert "none of 12" in change_in_words(shifts(applied(parameters(before)), parameters(before)), before)
    assert "no parameter to compare" in change_in_words({}, before)


def test_a_row_shows_the_uncertainty_it_was_judged_by_and_what_of_the_limit_that_leaves() -> None:
    limit = Limit("accelerometer.bias.y", -2.5e-3, 2.5e-3, "g", 2.0)
    budget = combined_budget(limit.parameter, 2e-3, "g", {SourceCell(HEADING): 1e-4**2})
    outcome = judge(document(), [limit], {budget.name: budget.std})
    rows = {row.name: row for row in verdict_rows(parameters(document()), outcome, {}, [budget])}
    judged, other = rows["accelerometer bias y"], rows["accelerometer bias x"]
    assert (judged.value, judged.sigma, judged.expanded) == ("2000.000", "100", "196")
    assert judged.limit == "+-2500 ug, minus 2 u: +-2300"
    assert (
        "accelerometer bias y, which uses 87 % of the accepted range (limit minus 2 u)" in outcome.sentence
    )  # 2000 of 2300
    assert (other.sigma, other.expanded) == ("0.080", "")
    narrow = replace(limit, guard_band=30.0)
    [failed] = judge(document(), [narrow], {budget.name: budget.std}).judged
    assert judged_in_words(failed) == "+-2500 ug, minus 30 u (u is too large: no value is accepted)"
    [upper] = judge(document(), [replace(limit, low=None)], {budget.name: budget.std}).judged
    assert judged_in_words(upper) == "at most 2500 ug, minus 2 u: at most 2300"


@pytest.mark.parametrize("count", range(1, 7))
def test_the_faces_that_are_enough_to_finish_are_those_that_determine_a_solution(count: int) -> None:
    for faces in combinations(FACES, count):
        steps = [
            StepView(name=f"dwell_{p:02d}", state="todo", position=p, attempts=face_of(p) in faces)
            for p in range(1, 13)
        ]
        assert (why_not_solvable(steps) == "") == is_determined(np.stack([face_normal(face) for face in faces]))
