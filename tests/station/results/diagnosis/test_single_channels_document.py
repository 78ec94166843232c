"""A gyroscope's only live channel of -3600 counts a degree, as the document and the lines say it."""

from types import SimpleNamespace

import pytest

from procedures.diagnosis.single_channels import SingleChannel
from procedures.statistics.line_with_correlated_errors import CorrelatedLine
from procedures.statistics.noise_terms import NoiseTerm
from station.results.diagnosis import single_channels
from station.results.diagnosis.single_channels import channel_lines, channels_of

LIVE = SingleChannel(
    "gyroscope", "y", "dwell_05", 600.0, 7.2, NoiseTerm(3.0, 2.4, 3.6), NoiseTerm(0.1, 0.08, 0.12),
    CorrelatedLine(0.5, 0.1, 9.0), CorrelatedLine(-0.2, 0.04, 9.0), 3.0, (-3600.0, 1.0), is_count=True,
)  # fmt: skip


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch) -> dict[str, object]:
    """The document of the channel, whatever campaign it came from."""
    monkeypatch.setattr(single_channels, "single_channels", lambda campaigns, solved: [LIVE])
    campaign = SimpleNamespace(
        tables=SimpleNamespace(imu=SimpleNamespace(output="counts")), campaign=SimpleNamespace(nominal_scale={})
    )
    (found,) = channels_of([campaign], [])  # type: ignore[list-item]
    return found


def test_a_channel_with_a_scale_factor_is_told_in_degrees(told: dict[str, object]) -> None:
    # 7.2 count/s over -3600 count/deg are -0.002 deg/s, -7.2 deg/h; noise by 60 / 3600 to deg/sqrt(h)
    assert told["mean"] == {"value": pytest.approx(-7.2), "unit": "deg/h"}
    walk = {"value": 0.05, "low": 0.04, "high": 0.06}
    assert told["random_walk"] == {key: pytest.approx(v) for key, v in walk.items()} | {"unit": "deg/sqrt(h)"}
    assert told["bias_instability"] == {
        "value": pytest.approx(0.1), "low": pytest.approx(0.08), "high": pytest.approx(0.12), "unit": "deg/h",
    }  # fmt: skip
    assert told["drift"] == {"value": pytest.approx(-0.5), "std": pytest.approx(0.1), "unit": "deg/h/h"}
    assert told["by_temperature"] == {"value": pytest.approx(0.2), "std": pytest.approx(0.04), "unit": "deg/h/K"}
    assert told["scale_factor"] == {"value": -3600.0, "std": 1.0, "unit": "count/deg"}


def test_its_lines_say_what_is_known_and_that_drift_may_be_temperature(told: dict[str, object]) -> None:
    lines = [" ".join(line.split()) for line in channel_lines([told])]
    assert lines[0] == "gyroscope y alone, 600 s of dwell_05"
    assert {
        "scale factor -3600.0 +- 1.0 count/deg",
        "drift -0.50 +- 0.10 deg/h/h",
        "by temperature 0.200 +- 0.040 deg/h/K",
        "random walk 0.05 deg/sqrt(h), 95 % 0.04 to 0.06",
    } < {*lines}
    assert lines[-1] == "the temperature moved by 3.0 K: drift and temperature may be one and the same"
