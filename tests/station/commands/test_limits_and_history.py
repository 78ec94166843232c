"""Limits come from a file; a unit's history is listed with its drift."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fixtures_db.database import open_db
from fixtures_db.history import accept_calibration
from station import cli
from tests.fixtures_db.factory import facts, solution

LIMITS = """model = "FOG-3"
[[limit]]
parameter = "accelerometer.bias"
low = -0.002
high = 0.002
unit = "g"
guard_band = 1.64
[[limit]]
parameter = "residual.p_value"
low = 0.01
unit = "1"
"""


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str]:
    code = cli.run(list(arguments))
    captured = capsys.readouterr()
    return code, captured.out + captured.err


def test_limits_are_imported_and_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    db = ("--db", str(tmp_path / "s.db"))
    (tmp_path / "limits.toml").write_text(LIMITS)
    assert run(capsys, "fixtures", "limits", *db) == (0, "no IMU model has limits\n")
    code, text = run(capsys, "fixtures", "limits", "FOG-3", "--import", str(tmp_path / "limits.toml"), *db)
    assert code == 0
    code, text = run(capsys, "fixtures", "limits", "FOG-3", *db)
    assert code == 0
    assert text.splitlines() == [
        "FOG-3: 4 limits",
        *(f"  accelerometer.bias.{axis}: from -0.002 to 0.002 g, guard band 1.64 sigma" for axis in "xyz"),
        "  residual.p_value: from 0.01 1",
    ]
    assert run(capsys, "fixtures", "limits", *db) == (0, "FOG-3\n")
    code, text = run(capsys, "fixtures", "limits", "FOG-4", *db)
    assert (code, "it has FOG-3" in text) == (3, True)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("FOG-3", "FOG-4"), "limits of model 'FOG-4', expected 'FOG-3'"),
        (
            ("accelerometer.bias", "accelerometer.bais"),
            "limits.toml:2: found limit with parameter = ",
        ),
        (("low = -0.002", 'low = "x"'), "limits.toml:4: found limit.low = 'x'"),
        (("guard_band", "guardband"), "limits.toml:7: found unknown key"),
        (("residual.p_value", "accelerometer.bias.y"), "expected the unit of accelerometer.bias.y to be g"),
        (
            ('"1"', '"1"\n[[limit]]\nparameter = "accelerometer.bias.y"\nhigh = 1\nunit = "g"'),
            ":12: found a second",
        ),
        (("[[limit]]", "[limit]"), "limits.toml"),
        ((LIMITS, ""), "found no model"),
    ],
)
def test_a_file_that_holds_no_limits_is_refused_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], change: tuple[str, str], said: str
) -> None:
    (tmp_path / "limits.toml").write_text(LIMITS.replace(*change))
    arguments = ("fixtures", "limits", "FOG-3", "--import", str(tmp_path / "limits.toml"))
    code, text = run(capsys, *arguments, "--db", str(tmp_path / "s.db"))
    assert code == 3
    assert said in text
    code, text = run(capsys, "fixtures", "limits", "--db", str(tmp_path / "s.db"))
    assert text == "no IMU model has limits\n"


def test_an_import_needs_a_model_and_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    db = ("--db", str(tmp_path / "s.db"))
    assert run(capsys, "fixtures", "limits", "--import", "x", *db)[0] == 2
    assert run(capsys, "fixtures", "list", "--import", "x", *db)[0] == 2
    code, text = run(capsys, "fixtures", "limits", "FOG-3", "--import", str(tmp_path / "none"), *db)
    assert (code, "no readable file" in text) == (3, True)


def test_history_lists_calibrations_with_their_drift(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    db = ("--db", str(tmp_path / "s.db"))
    step = 5 * np.sqrt(2) * 8e-8
    with open_db(tmp_path / "s.db") as database, database.write() as session:
        for serial, bias in (("S1", 1e-3), ("S2", 5e-3), ("S1", 1e-3 - step)):
            accept_calibration(session, solution(bias), facts(serial))
    code, text = run(capsys, "history", "S1", *db)
    assert code == 0
    heads = [line for line in text.splitlines() if line.startswith("2026-")]
    assert len(heads) == 2
    assert all(line.startswith("2026-03-04 12:00 UTC  FOG-3  not judged, calibrated  ") for line in heads)
    assert "  accelerometer bias x             1000.000 +- 0.080 ug\n" in text
    assert "  moved most: accelerometer bias x, -0.566 ug (5.0 sigma)\n" in text
    assert "  moved significantly (p < 0.05, Holm): 1 of 12\n" in text
    assert "FOG-3, turn-ons: 1, 2026-03-04 to 2026-03-04\n" in text  # one recording, solved twice
    code, _ = run(capsys, "history", "S1", "--json", str(tmp_path / "h.json"), *db)
    first, second = json.loads((tmp_path / "h.json").read_text())["calibrations"]
    assert (code, first["drift"]) == (0, {})
    assert second["drift"]["accelerometer.bias.x"]["shift_sigma"] == pytest.approx(-5.0)
    assert second["drift"]["accelerometer.bias.x"]["p_adjusted"] == pytest.approx(12 * 5.73e-7, rel=1e-2)
    assert second["parameters"]["accelerometer.scale_factor.x"]["value"] == 1020.0
    code, text = run(capsys, "history", "S3", *db)
    assert (code, "it has S1, S2" in text) == (3, True)


def test_a_page_is_written_of_a_unit_and_of_a_population(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    db = ("--db", str(tmp_path / "s.db"))
    with open_db(tmp_path / "s.db") as database, database.write() as session:
        for i in range(4):
            accept_calibration(
                session, solution(1e-3 + 1e-6 * i), replace(facts(), inputs={"dwell_01.csv": str(i)})
            )
    page, out = tmp_path / "h.html", tmp_path / "p.json"
    written = f"{page}: history of S1\n"
    assert run(capsys, "history", "S1", "--html", str(page), "--at", "2027-05-06", *db) == (0, written)
    assert "too short a history to predict: 4 turn-ons over 0 days" in page.read_text()
    written = f"{out}: population/1 of FOG-3\n{page}: history of FOG-3\n"
    many = ("--population", "FOG-3", "--html", str(page), "--json", str(out))
    assert run(capsys, "history", *many, *db) == (0, written)
    assert "<h1>All units of FOG-3</h1>" in page.read_text()
    assert json.loads(out.read_text())["turn_ons"] == 4


def test_wrong_usage_and_what_is_not_stored_are_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    db = ("--db", str(tmp_path / "s.db"))
    with open_db(tmp_path / "s.db") as database, database.write() as session:
        accept_calibration(session, solution(), facts())
    for arguments, code, said in (
        ((), 2, "expected a serial number or --population"),
        (("S1", "--population", "FOG-3"), 2, "one of the two"),
        (("--population", "FOG-3", "--at", "2030-01-01"), 2, "a population is not predicted"),
        (("S1", "--at", "2020-01-01"), 2, "expected a date after the newest, 2026-03-04"),
        (("--population", "FOG-4"), 3, "no calibration of model 'FOG-4' in the database (it has FOG-3)"),
    ):
        found, text = run(capsys, "history", *arguments, *db)
        assert (found, said in text) == (code, True)
