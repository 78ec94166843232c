"""history/1 from one calibration to many, with old documents, other units and recordings solved twice."""

import json
from dataclasses import replace
from datetime import datetime, timedelta

import numpy as np
import pytest

from fixtures_db.hash_chain import utc_text
from fixtures_db.imu_models import Limit, each_axis
from fixtures_db.stored_calibrations import Run
from station.results.history.unit_history import UnitHistory, analysis, unit_history
from station.results.history.unit_history_text import history_text
from station.results.result_formats import document_of
from tests.station.results.history.fleets import BEGIN, MODEL, fleet, run, solution

LIMITS = each_axis(Limit("accelerometer.bias", -2e-3, 2e-3, "g"))


def unit(each: int, seed: int = 1) -> list[Run]:
    return fleet(np.random.default_rng(seed), units=1, each=each)


def history(runs: list[Run], limits: tuple[Limit, ...] = LIMITS) -> UnitHistory:
    return unit_history("S0", runs, {MODEL: limits})


@pytest.mark.parametrize("each", [1, 2, 3, 9])
@pytest.mark.parametrize("limits", [LIMITS, ()])
def test_any_number_of_calibrations_gives_text_of_80_columns_and_json_without_nan(
    each: int, limits: tuple[Limit, ...]
) -> None:
    found = history(unit(each), limits)
    json.dumps(document_of(found), allow_nan=False)
    lines = history_text(found).splitlines()
    assert max(map(len, lines)) <= 80
    assert any("the history is too short to predict" in line for line in lines) == (each < 3)
    assert sum(line.startswith("  significant changes") for line in lines) == each - 1


def test_it_is_predicted_for_the_due_date_with_the_probability_to_be_outside() -> None:
    runs = unit(6)
    found = analysis(runs, LIMITS, None)
    assert found.predicted_utc == runs[-1].document["valid_until"]
    bias = found.parameters["accelerometer.bias.x"]
    assert bias.prediction is not None
    assert bias.prediction.probability_outside is not None
    low, high = bias.prediction.interval_95
    assert low < bias.value[-1] < high
    assert 0 <= bias.prediction.probability_outside < 0.05
    assert bias.limits == {"low": -2e-3, "high": 2e-3}
    assert found.parameters["gyroscope.bias.x"].limits is None
    year = runs[-1].ended + timedelta(days=3000)
    later = analysis(runs, LIMITS, year).parameters["accelerometer.bias.x"].prediction
    assert later is not None
    assert later.interval_95[1] - later.interval_95[0] > high - low


@pytest.mark.parametrize(("valid_days", "due_days"), [(200, 200), (-1, 365), (None, 365)])
def test_it_is_due_when_the_newest_says_or_else_a_year_after_it(valid_days: int | None, due_days: int) -> None:
    *before, newest = unit(6)
    valid = None if valid_days is None else (newest.ended + timedelta(days=valid_days)).isoformat()
    found = analysis([*before, replace(newest, document={**newest.document, "valid_until": valid})], LIMITS, None)
    assert datetime.fromisoformat(found.predicted_utc) == newest.ended + timedelta(days=due_days)


def test_a_jump_beyond_the_turn_on_scatter_is_an_alarm_of_that_calibration() -> None:
    runs = unit(12)
    jumped = solution(np.random.default_rng(9), np.array([1500.0, 0.0, 0.0]))
    runs.append(run("S0", runs[-1].ended + timedelta(days=200), "jump", "CUBE-1", jumped))
    all_of_it = history(runs)
    found = all_of_it.analysis[0].parameters["accelerometer.bias.x"]
    assert found.chart is not None
    assert found.chart.alarms == [runs[-1].sha256]
    text = history_text(all_of_it)
    assert "alarm on" in text
    *_, reported = (line for line in text.splitlines() if "significant changes" in line)
    p = np.array([one.p_adjusted for one in all_of_it.calibrations[-1].drift.values()])
    assert reported.endswith(f": {np.sum(p < 0.05)} of {len(p)}")


def test_turn_ons_within_a_week_give_the_repeatability() -> None:
    rng = np.random.default_rng(3)
    runs = [
        run("S0", BEGIN + timedelta(days=i), str(i), "CUBE-1", solution(rng, 50.0 * rng.standard_normal(3)))
        for i in range(6)
    ]
    scatter = analysis(runs, LIMITS, None).parameters["accelerometer.bias.y"].repeatability
    assert scatter is not None
    assert scatter.interval_95[0] < 50e-6 < scatter.interval_95[1]


def test_another_unit_or_no_sigma_leaves_a_value_out_and_says_so() -> None:
    runs = unit(5)
    runs[0].document["accelerometer"]["bias"]["unit"] = "m/s2"
    runs[1].document["accelerometer"]["bias"]["std"] = [0.0, 1e-6, 1e-6]
    found = analysis(runs, LIMITS, None)
    assert found.left_out[0] == "accelerometer.bias.x: 2 of 5 not in g or without uncertainty"
    assert len(found.parameters["accelerometer.bias.x"].value) == 3
    assert len(found.parameters["accelerometer.bias.y"].value) == 4


def test_a_triad_that_was_not_solved_is_absent_there_only() -> None:
    runs = unit(4)
    del runs[-1].document["gyroscope"]
    found = history(runs)
    assert len(found.analysis[0].parameters["gyroscope.bias.x"].value) == 3
    assert "gyroscope.bias.x" not in found.calibrations[-1].parameters
    history_text(found)


def near(minutes: int, each: int = 3) -> list[Run]:
    rng = np.random.default_rng(5)
    return [
        run("S0", BEGIN + timedelta(minutes=minutes * i), str(i), "CUBE-1", solution(rng, rng.standard_normal(3)))
        for i in range(each)
    ]


def test_it_is_predicted_no_farther_than_three_times_the_history() -> None:
    runs = near(10 * 24 * 60)  # 0, 10, 20 days
    found = analysis(runs, each_axis(Limit("accelerometer.bias", -1e-5, 1e-5, "g")), None)
    last = runs[-1].ended + timedelta(days=60)
    assert found.predicted_utc == utc_text(last)
    assert found.predicted_because.startswith("3 times its history, not 20")
    for one in found.parameters.values():
        assert one.prediction is not None
        assert one.prediction.fan[-1][0] <= utc_text(last)
        assert (one.prediction.interval_reaches_limit_utc or "") <= utc_text(last)
