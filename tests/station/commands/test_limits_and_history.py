"""Limits come from a file; a unit's history is listed with its drift."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from fixtures_db.stored_calibrations import accept_calibration
from station import cli
from station.demo.comparison import truth_values
from station.errors import DataRefused
from station.files.limits_example import example_limits
from station.files.limits_toml import limits_in
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
        *(f"  accelerometer.bias.{axis}: +-2000 ug less 1.64 sigma" for axis in "xyz"),
        "  residual.p_value: at least 0.01",
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
        (
            ("residual.p_value", "accelerometer.bias.y"),
            "expected the unit of accelerometer.bias.y to be one of g, mg, ug",
        ),
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


def of_unit(parameter: str, *lines: str) -> bytes:
    return "\n".join(['model = "M"', "[[limit]]", f'parameter = "{parameter}"', *lines]).encode()


@pytest.mark.parametrize(
    ("parameter", "lines", "expected"),
    [
        ("accelerometer.bias.x", ("low = -2000", "high = 2000", 'unit = "ug"'), (-2e-3, 2e-3, "g")),
        ("accelerometer.bias.x", ("high = 2", 'unit = "mg"'), (None, 2e-3, "g")),
        ("accelerometer.bias.x", ("high = 9.80665e-3", 'unit = "m/s2"'), (None, 1e-3, "g")),
        ("gyroscope.bias.x", ("high = 1e-3", 'unit = "deg/s"'), (None, 3.6, "deg/h")),
        ("gyroscope.misalignment.xy", ("high = 206.26480624709637", 'unit = "arcsec"'), (None, 1e-3, "1")),
        ("gyroscope.misalignment.xy", ("high = 1000", 'unit = "ppm"'), (None, 1e-3, "1")),
        ("slab.tilt.east", ("high = 206.26480624709637", 'unit = "arcsec"'), (None, 1e-3, "rad")),
        ("gyroscope.scale_factor.x", ("high = 37000", 'unit = "count/deg"'), (None, 37000.0, "count/deg")),
        (
            "gyroscope.scale_factor.x",
            ("nominal = 36000", "low = -1000", "high = 500", 'unit = "ppm"'),
            (35964.0, 36018.0, "count/deg"),
        ),
    ],
)
def test_a_limit_is_taken_in_the_unit_of_the_screen(
    parameter: str, lines: tuple[str, ...], expected: tuple[float | None, float | None, str]
) -> None:
    _, (found,) = limits_in(of_unit(parameter, *lines), Path("limits.toml"))
    assert (found.low, found.high) == pytest.approx(expected[:2], rel=1e-12)
    assert found.unit == expected[2]


@pytest.mark.parametrize(
    ("parameter", "lines", "said"),
    [
        ("gyroscope.scale_factor.x", ("high = 1", 'unit = "ppm"'), "a nominal value in count/deg"),
        ("gyroscope.bias.x", ("high = 1", "nominal = 3", 'unit = "deg/h"'), "nominal above 0 of a scale factor"),
        ("gyroscope.bias.x", ("high = 1", 'unit = "arcsec"'), "to be one of deg/h, deg/s, rad/s"),
        ("gyroscope.scale_factor.x", ("high = 1", 'unit = "g"'), "count/deg, output/(deg/s), ppm with a nominal"),
        ("residual.p_value", ("high = 1", 'unit = "%"'), "to be one of 1"),
    ],
)
def test_a_unit_that_does_not_fit_is_refused_with_those_that_do(
    parameter: str, lines: tuple[str, ...], said: str
) -> None:
    with pytest.raises(DataRefused, match=re.escape(said)):
        limits_in(of_unit(parameter, *lines), Path("limits.toml"))


def test_the_sample_is_one_that_can_be_imported_and_all_simulated_units_pass_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    db = ("--db", str(tmp_path / "s.db"))
    code, sample = run(capsys, "fixtures", "limits", "FOG-A", "--example", *db)
    (tmp_path / "limits.toml").write_text(sample)
    assert (code, run(capsys, "fixtures", "limits", "FOG-A", "--import", str(tmp_path / "limits.toml"), *db)[0]) \
        == (0, 0)  # fmt: skip
    code, text = run(capsys, "fixtures", "limits", "FOG-A", *db)
    assert "  accelerometer.bias.x: +-12000 ug less 2 sigma\n" in text
    assert "  gyroscope.misalignment.xy: +-900 arcsec less 2 sigma\n" in text
    model, limits = limits_in(example_limits().encode(), Path("limits.toml"))
    assert model == Truth.example(1).model
    for seed in range(1, 200):
        values = truth_values(Truth.example(seed))
        assert all(low <= values[one.parameter] <= high for one in limits for low, high in [one.accepted(None)])


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
