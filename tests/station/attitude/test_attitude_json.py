"""A track of four rows, 10 degrees off in roll, as the document, the words and the rows that are made of it."""

from pathlib import Path

import numpy as np
import pytest

from procedures.attitude.attitude_estimate import AttitudeEstimate
from procedures.attitude.attitude_log import AttitudeLog
from procedures.attitude.complementary_gains import ComplementaryGains
from procedures.attitude.complementary_velocity_aids import Observability
from procedures.attitude.gain_tuning import GainTuning
from station.attitude.attitude_json import attitude_document, attitude_text, rms_deg, tuning_document, write_track

TEN = np.radians(10.0)
DOWN = np.tile([0.0, np.sin(TEN), np.cos(TEN)], (4, 1))  # roll of 10 degrees, forward-right-down


def log(**more: np.ndarray) -> AttitudeLog:
    return AttitudeLog(np.array([0.0, 0.5, 1.0, 3.0]), np.zeros((4, 3)), np.zeros((4, 3)), **more)


def track(**more: object) -> AttitudeEstimate:
    bias, std = np.radians([1.0, 2.0, -3.0]) / 3600, np.radians([0.1, 0.2, 0.3]) / 3600
    return AttitudeEstimate("gnss", DOWN, np.radians([0.1, 0.2, 0.4, 0.3]), bias, std, {"k1": 0.5}, **more)


def test_the_document_holds_what_was_estimated() -> None:
    seen = Observability(12.0, 3.5, 0.25)
    document = attitude_document(log(), track(warnings=("late",), observability=seen))
    assert (document["format"], document["aid"], document["rows"]) == ("attitude/1", "gnss", 4)
    assert document["parameters"] == {"k1": 0.5}
    assert document["gaps"] == [[1.0, 3.0]]
    assert document["sigma_deg"] == pytest.approx(0.25)
    assert document["observability"] == {"open_s": 12.0, "determinant_rms_rad3_s3": 3.5, "rank_3_share": 0.25}
    assert document["warnings"][-1] == "late"
    assert "rms_deg" not in document
    text = attitude_text(log(), document)
    assert all(value in text for value in ("1.0 2.0 -3.0 deg/h", "0.1 0.2 0.3", "0.250 deg", "12.0 s", "25 %"))


def test_errors_are_of_scored_rows_with_truth() -> None:
    level = {"roll": np.zeros(4), "pitch": np.array([0.0, 0.0, np.nan, 0.0])}
    found = rms_deg(log(**level), DOWN)
    assert found is not None
    assert found == pytest.approx({"roll": 10.0, "pitch": 0.0, "inclination": 10.0}, abs=1e-9)
    half = level | {"roll": np.array([0.0, TEN, 0.0, TEN])}
    assert rms_deg(log(**half, scored=np.array([False, True, False, True])), DOWN)["roll"] == pytest.approx(0.0)
    assert rms_deg(log(**half), DOWN)["roll"] == pytest.approx(10.0 / np.sqrt(3))
    assert rms_deg(log(**half, scored=np.zeros(4, bool)), DOWN) is None
    assert "error rms roll 10.000 deg, pitch 0.000 deg" in attitude_text(
        log(**level), attitude_document(log(**level), track())
    )


def test_a_roll_past_half_a_turn_is_no_error_of_a_turn() -> None:
    down = np.tile([0.0, np.sin(-np.pi + 0.01), np.cos(-np.pi + 0.01)], (4, 1))
    found = rms_deg(log(roll=np.full(4, np.pi - 0.01), pitch=np.zeros(4)), down)
    assert found is not None
    assert found["roll"] == pytest.approx(np.degrees(0.02))


def test_rows_are_written_as_they_are_named(tmp_path: Path) -> None:
    write_track(tmp_path / "track.csv", log(), track())
    first, *rows = (tmp_path / "track.csv").read_text().splitlines()
    assert first == "t_s,roll_rad,pitch_rad,down_x,down_y,down_z"
    assert len(rows) == 4
    assert [float(cell) for cell in rows[3].split(",")] == pytest.approx(
        [3.0, TEN, 0.0, 0.0, np.sin(TEN), np.cos(TEN)], abs=1e-7
    )


DEG = np.pi / 180
TUNING = GainTuning(
    candidates=(ComplementaryGains(2.0, 1.0), ComplementaryGains(0.5, 0.25), ComplementaryGains(0.2, 0.04)),
    rms=np.array([4.0, 1.0, 2.0]) * DEG, by_fold=np.array([[4.0, 4.0], [1.0, 1.0], [2.0, 2.0]]) * DEG,
    best=1, picked=(1, 2), held_out=1.5 * DEG, rows=600,
)  # fmt: skip


def test_a_tuning_over_time_constants_gives_the_chosen_one_and_the_curve_in_degrees() -> None:
    document = tuning_document(TUNING, "gnss", by_tau=True)
    assert (document["format"], document["aid"], document["rows"], document["warnings"]) == (
        "tuning/1",
        "gnss",
        600,
        [],
    )
    assert document["chosen"] == {"tau_s": 4.0, "k1": 0.5, "k2": 0.25}  # tau = 2 / K1
    assert (document["rms_deg"], document["held_out_rms_deg"]) == pytest.approx((1.0, 1.5))
    assert document["chosen_without_stretch"] == [4.0, 10.0]
    assert [point["tau_s"] for point in document["curve"]] == [1.0, 4.0, 10.0]
    assert [point["rms_deg"] for point in document["curve"]] == pytest.approx([4.0, 1.0, 2.0])
    assert document["curve"][2]["by_stretch_deg"] == pytest.approx([2.0, 2.0])
