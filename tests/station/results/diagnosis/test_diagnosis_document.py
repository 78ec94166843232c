"""What a diagnosis says of turns, single channels, terms without a unit and causes, in its document and words."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from procedures.campaign.campaign import Campaign, Fixture, ProcedureSigma, Site
from procedures.diagnosis.single_channels import SingleChannel
from procedures.inference.result import Because
from procedures.statistics.allan_deviation import NoiseTerm
from procedures.statistics.line_fits import CorrelatedLine
from procedures.units import DEG_H_PER_DEG_S
from station.files.effect_file import effect_in
from station.results.diagnosis import uncalibrated
from station.results.diagnosis.diagnosis_wording import not_looked_at, verdict_sentence
from station.results.diagnosis.finding_figure import Coordinate, ResidualPanel, caption, draw_panel
from station.results.diagnosis.finding_wording import p_text
from station.results.diagnosis.uncalibrated import channels_of, in_specified_unit, turns, turns_lines
from tests.procedures.diagnosis.test_turns_seen import SCALE, recorded


def test_a_chance_is_stated_in_plain_words_however_small() -> None:
    reported = [p_text(log10_p) for log10_p in (0.0, -0.42, -2.5, -5.3, -12.2, -400.0)]
    assert reported == ["p > 0.99", "p = 0.38", "p = 0.0032", "p = 5e-06", "p = 6e-13", "p < 1e-300"]


def test_gyroscopes_that_no_residual_was_diagnosed_of_are_reported_as_not_looked_at() -> None:
    solution = {"accelerometer": {}, "gyroscope": {}}
    document = {"error": [{"quantity": "accelerometer bias"}], "solution": solution}
    assert len(not_looked_at(document)) == 1
    assert not_looked_at(document | {"error": [{"quantity": "gyroscope bias"}]}) == []
    assert not_looked_at(document | {"solution": {"gyroscope": {}}}) == []
    assert not_looked_at({"error": []}) == []


def test_the_verdict_says_whose_residuals_it_is_of() -> None:
    document = {
        "log10_p": -0.1,
        "verdict": "consistent",
        "findings": [],
        "error": [{"quantity": "accelerometer rests"}],
    }
    both = {"accelerometer": {}, "gyroscope": {}}
    assert "of the accelerometers" in verdict_sentence(document | {"solution": both})
    assert "of the accelerometers" not in verdict_sentence(document | {"solution": {"accelerometer": {}}})


def test_a_disturbance_is_in_outputs_where_the_unit_is_not_specified() -> None:
    size = {"coefficients": {"x": {"value": 3600.0, "std": 36.0}}, "unit": "deg/h"}
    found = in_specified_unit(size, "disturbance.dwell", [recording()])  # type: ignore[list-item]
    assert (found["unit"], found["coefficients"]["x"]["value"]) == (
        "output",
        pytest.approx(3600 / DEG_H_PER_DEG_S),
    )


LIVE = SingleChannel(
    "gyroscope", "y", "dwell_05", 600.0, 7.2, NoiseTerm(3.0, 2.4, 3.6), NoiseTerm(0.1, 0.08, 0.12),
    CorrelatedLine(0.5, 0.1, 9.0), CorrelatedLine(-0.2, 0.04, 9.0), 3.0, (-3600.0, 1.0), is_count=True,
)  # fmt: skip


def recording(**nominal_scale: float) -> SimpleNamespace:
    """A recording of counts, or in a unit that was stated."""
    imu, campaign = SimpleNamespace(output="counts"), SimpleNamespace(nominal_scale=nominal_scale)
    return SimpleNamespace(tables=SimpleNamespace(imu=imu), campaign=campaign, output_name="")


@pytest.fixture
def noticed(monkeypatch: pytest.MonkeyPatch) -> dict[str, object]:
    """The document of the channel, whatever campaign it came from."""
    monkeypatch.setattr(uncalibrated, "single_channels", lambda campaigns, solved: [LIVE])
    (found,) = channels_of([recording()], [])  # type: ignore[list-item]
    return found


def test_a_channel_with_a_scale_factor_is_reported_in_degrees(noticed: dict[str, object]) -> None:
    # 7.2 count/s over -3600 count/deg are -0.002 deg/s, -7.2 deg/h; noise by 60 / 3600 to deg/sqrt(h)
    assert noticed["mean"] == {"value": pytest.approx(-7.2), "unit": "deg/h"}
    walk = {"value": 0.05, "low": 0.04, "high": 0.06}
    assert noticed["random_walk"] == {key: pytest.approx(v) for key, v in walk.items()} | {"unit": "deg/sqrt(h)"}
    assert noticed["bias_instability"] == {
        "value": pytest.approx(0.1), "low": pytest.approx(0.08), "high": pytest.approx(0.12), "unit": "deg/h",
    }  # fmt: skip
    assert noticed["drift"] == {"value": pytest.approx(-0.5), "std": pytest.approx(0.1), "unit": "deg/h/h"}
    assert noticed["by_temperature"] == {
        "value": pytest.approx(0.2),
        "std": pytest.approx(0.04),
        "unit": "deg/h/K",
    }
    assert noticed["scale_factor"] == {"value": -3600.0, "std": 1.0, "unit": "count/deg"}


SITE, CARE = Site(0.8, 9.80665, 0.02), ProcedureSigma(0.001, 2e-5)


def test_of_several_turns_the_mean_scale_factor_is_reported_next_to_each() -> None:
    both = (recorded(1, 720.0), recorded(2, 720.0, "-"))
    found = turns([Campaign("M", "S", False, SITE, (), both, CARE, Fixture())])
    assert len(found["turns"]) == 2
    [mean] = found["turns_mean"]
    assert mean["channel"] == "gyroscope z"
    assert mean["scale_factor"]["value"] == pytest.approx(SCALE, abs=4 * mean["scale_factor"]["std"])
    assert any(line.startswith("gyroscope z, all turns: 1.01") for line in turns_lines(found))


EFFECT = b"""format = "effect/1"
name = "warm_up"
triad = "gyroscope"
term = "exp(-t / relaxes) * lag(T, tau_s)"
unit = "deg/h/K"
plausible = 1.0
source = "a test"
shape.relaxes = {unit = "s", low = 60, high = 6000}
shape.tau_s = {unit = "s", low = 60, high = 6000}
"""


def test_the_parameters_of_an_effect_of_ones_own_stay_as_they_are() -> None:
    file = effect_in(EFFECT, Path("warm_up.toml"))
    seconds = {"value": 600.0, "std": 20.0}
    entry = {
        "effect": file.name, "unit": "deg/h/K", "definition": file.text, "sha256": file.sha256,
        "times_expected": 3.0,
        "error": [{"quantity": "gyroscope soaks", "unit": "deg/h", "held_out_before": 36.0}],
        "coefficients": {"x": {"value": 36.0, "std": 3.6}, "relaxes": seconds, "tau_s": seconds},
    }  # fmt: skip
    found = in_specified_unit(entry, file.name, [recording()])  # type: ignore[list-item]
    assert found["unit"] == "output/K"
    assert found["error"] == [{
        "quantity": "gyroscope soaks", "unit": "output", "held_out_before": 36.0 / DEG_H_PER_DEG_S,
    }]  # fmt: skip
    assert "times_expected" not in found  # that is of deg/h
    assert found["coefficients"]["x"] == {"value": 36.0 / DEG_H_PER_DEG_S, "std": 3.6 / DEG_H_PER_DEG_S}
    assert found["coefficients"]["relaxes"] == seconds
    assert found["coefficients"]["tau_s"] == seconds
    assert in_specified_unit(entry, file.name, [recording(gyroscope=1.0)]) == entry  # type: ignore[list-item]


PANEL = ResidualPanel(
    "accelerometer.quadratic", "accelerometer", "mean", "ug",
    Coordinate("specific force [g]", np.array([-1.0, 0.0, 1.0])),
    np.array([0, 0, 2]), np.array([3.0, 4.0, 0.0]), np.array([0.3, 0.4, 0.0]), np.array([1.0, 2.0, 3.0]),
)  # fmt: skip


def test_the_rows_of_each_sensor_are_drawn_before_and_after() -> None:
    figure = Figure()
    draw_panel(figure, PANEL)
    left, right = figure.axes
    for axes, values in ((left, [[3.0, 4.0], [0.0]]), (right, [[0.3, 0.4], [0.0]])):
        drawn = axes.containers
        assert [each.get_label() for each in drawn] == ["ax", "az"]
        assert [each.lines[0].get_xdata().tolist() for each in drawn] == [[-1.0, 0.0], [1.0]]
        assert [each.lines[0].get_ydata().tolist() for each in drawn] == values
    assert [each.get_title(loc="left") for each in (left, right)] == ["without it", "with it"]
    assert caption(PANEL) == "Accelerometer, dwells; bars: 1\u03c3 of counting noise."


def test_a_reason_of_several_findings_is_stated_once() -> None:
    walk = {"code": Because.NAMELESS, "what": "a random walk", "value": 0.9}
    curve = {"code": Because.NAMELESS, "what": "a function of time", "value": 0.8}
    document = {"log10_p": -9.0, "verdict": "unexplained", "findings": [], "reasons": [walk, curve, walk, walk]}
    sentence = verdict_sentence(document)
    assert sentence.count("random walk") == 1
    assert sentence.count("a function of time") == 1
