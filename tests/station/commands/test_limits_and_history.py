"""Limits come from a file; a unit's history is listed with its drift."""

import json
from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.truth import Truth
from fixtures_db.database import open_db
from fixtures_db.stored_calibrations import accept_calibration
from station import cli
from station.demo.comparison import truth_values
from station.errors import DataRefused
from station.files.limits_file import example_limits, limits_in
from tests.fixtures_db.factory import facts, solution
from tests.refusals import refused


def run(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str]:
    code = cli.run(list(arguments))
    captured = capsys.readouterr()
    return code, captured.out + captured.err


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
    ("parameter", "lines", "reported"),
    [
        ("gyroscope.scale_factor.x", ("high = 1", 'unit = "ppm"'), "count/deg"),
        ("gyroscope.bias.x", ("high = 1", "nominal = 3", 'unit = "deg/h"'), "nominal"),
        ("gyroscope.bias.x", ("high = 1", 'unit = "arcsec"'), "deg/h, deg/s, rad/s"),
        ("residual.p_value", ("high = 1", 'unit = "%"'), "p_value"),
    ],
)
def test_a_unit_that_does_not_fit_is_refused_with_those_that_do(
    parameter: str, lines: tuple[str, ...], reported: str
) -> None:
    with refused(DataRefused, None, reported):
        limits_in(of_unit(parameter, *lines), Path("limits.toml"))


def test_all_simulated_units_pass_the_limits_of_the_sample() -> None:
    model, limits = limits_in(example_limits().encode(), Path("limits.toml"))
    assert model == Truth.example(1).model
    for seed in range(1, 60):
        values = truth_values(Truth.example(seed))
        assert all(low <= values[one.parameter] <= high for one in limits for low, high in [one.accepted(None)])


def test_history_lists_calibrations_with_their_drift(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    db = ("--db", str(tmp_path / "s.db"))
    step = 5 * np.sqrt(2) * 8e-8
    with open_db(tmp_path / "s.db") as database, database.write() as session:
        for serial, bias in (("S1", 1e-3), ("S2", 5e-3), ("S1", 1e-3 - step)):
            accept_calibration(session, solution(bias), facts(serial))
    code, text = run(capsys, "history", "S1", *db)
    assert code == 0
    assert len([line for line in text.splitlines() if line.startswith("2026-")]) == 2
    assert "1000.000 +- 0.080 ug" in text
    assert "-0.566 ug (5.0 u)" in text
    assert "turn-ons: 1," in text  # one recording, solved twice
    code, _ = run(capsys, "history", "S1", "--json", str(tmp_path / "h.json"), *db)
    first, second = json.loads((tmp_path / "h.json").read_text())["calibrations"]
    assert (code, first["drift"]) == (0, {})
    assert second["drift"]["accelerometer.bias.x"]["shift_sigma"] == pytest.approx(-5.0)
    assert second["drift"]["accelerometer.bias.x"]["p_adjusted"] == pytest.approx(12 * 5.73e-7, rel=1e-2)
    assert second["parameters"]["accelerometer.scale_factor.x"]["value"] == 1020.0
