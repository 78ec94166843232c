"""A campaign of a rate table alone: what was turned has its scale factor and bias in the diagnosis."""

import json
from pathlib import Path

import numpy as np
import pytest

from procedures.diagnosis.diagnose import diagnose
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign
from station.results.diagnosis.diagnosis_html import section_html
from station.results.diagnosis.diagnosis_json import diagnosis_json
from station.results.diagnosis.finding_figure import caption, residual_panels
from tests.procedures.diagnosis.test_rate_tables import table

TOML = """format = "campaign/1"
[imu]
model = "FOG-1"
serial = "7"
sample_period_s = 0.01
output = "OUTPUT"
[site]
latitude_deg = 40.0
[[rate]]
axis = "z"
file = "rates.csv"
"""


@pytest.mark.parametrize(("output", "unit"), [("rate", "output/(deg/s)"), ("increments", "count/deg")])
def test_scale_factor_and_bias_stand_in_document_and_summary(
    tmp_path: Path, output: str, unit: str, capsys: pytest.CaptureFixture[str]
) -> None:
    points = table(3, warm=-400.0, k=2e4)
    rows = np.column_stack((points.reference, points.output[:, 2], points.temperature))
    np.savetxt(tmp_path / "rates.csv", rows, "%.9g", ",", header="rate_ref_deg_s,gz,temp_c", comments="")
    (tmp_path / "campaign.toml").write_text(TOML.replace("OUTPUT", output))
    out = tmp_path / "out.json"
    assert cli.run(["diagnose", str(tmp_path), "--json", str(out)]) == 0
    document = json.loads(out.read_text())
    solution = document["solution"]
    assert "gyroscope" not in solution  # one axis is no triad
    found = solution["rate_tables"]
    assert found["unit"] == {"scale_factor": unit, "bias": "deg/h"}
    for name, true in (("scale_factor", 2e4), ("bias", 36.0)):
        assert list(found["gyroscope"][name]) == ["z"]
        one = found["gyroscope"][name]["z"]
        assert abs(one["value"] - true) < 4 * one["std"] < 0.5 * true
    assert solution["reference_temperature_c"] == 25.0
    assert "block of a rate table" in document["error"][0]["method"]
    capsys.readouterr()
    assert cli.run(["diagnose", str(tmp_path)]) == 0
    reported = capsys.readouterr().out
    assert "gyroscope scale factor z" in reported
    assert max(map(len, reported.splitlines())) <= 80


def test_points_of_a_table_are_drawn_at_their_own_rate_and_temperature_in_deg_s(tmp_path: Path) -> None:
    points = table(3, cubic=-2.0, warm=-400.0)
    rows = np.column_stack((points.reference, points.output[:, 2], points.temperature))
    np.savetxt(tmp_path / "rates.csv", rows, "%.9g", ",", header="rate_ref_deg_s,gz,temp_c", comments="")
    (tmp_path / "campaign.toml").write_text(TOML.replace("OUTPUT", "rate"))
    loaded = read_campaign(tmp_path)
    found = diagnose([loaded.campaign])
    page = section_html(diagnosis_json(found, [loaded]), None)
    assert "gyroscope scale factor z" in page  # what the summary says the page says
    assert "gyroscope.scale_nonlinearity" in page
    panels = residual_panels(found)
    assert len(panels) == 2
    for panel, along in zip(panels, (points.reference, points.temperature - 25.0), strict=True):
        assert np.allclose(panel.coordinate.values, along)  # not the mean of its block
        assert panel.unit == "deg/s"
        assert "scatter" in caption(panel)
        assert np.std(panel.after) < 0.2 * np.std(panel.before)
