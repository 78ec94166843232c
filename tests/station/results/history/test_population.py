"""An off unit and an off cube are named, each for what it is; its page shows them."""

import json
import re

import numpy as np
import pytest

from fixtures_db.imu_models import Limit, each_axis
from station.results.history.history_page import population_page, unit_page
from station.results.history.population import ALPHA, Population, population, population_text
from station.results.history.unit_history import unit_history
from station.results.result_formats import document_of
from tests.station.results.history.fleets import MODEL, fleet


def named(found: Population) -> tuple[set[str], set[str]]:
    units = {one.serial for track in found.parameters.values() for one in track.extremes if one.stands_out}
    return units, {one.id for one in found.groups if one.stands_out}


@pytest.mark.proof
def test_a_fleet_with_nothing_off_seldom_shows_anything() -> None:
    rng, fleets = np.random.default_rng(1), 40
    alarms = sum(named(population(MODEL, fleet(rng))) != (set(), set()) for _ in range(fleets))
    assert alarms / fleets < ALPHA + 3 * np.sqrt(ALPHA * (1 - ALPHA) / fleets)


def test_an_off_cube_is_named_and_not_the_good_ones_it_is_compared_with() -> None:
    for seed in (2, 105, 141):  # in the last two the good cubes' shifts are the less scattered ones
        runs = fleet(np.random.default_rng(seed), units=10, each=6, off_cube_ug=200.0)
        found = population(MODEL, runs)
        assert named(found) == (set(), {"CUBE-2"})
    off = [one for one in found.groups if one.stands_out]
    assert {one.parameter for one in off} == {f"accelerometer.bias.{axis}" for axis in "xyz"}
    for one in off:
        assert abs(one.shift - 200e-6) < 4 * one.std
        assert one.units == 10


def test_an_off_unit_is_named_and_no_cube() -> None:
    runs = fleet(np.random.default_rng(3), units=12, off_unit_ug=1500.0)
    assert named(population(MODEL, runs)) == ({"S2"}, set())


def test_what_cannot_be_determined_is_reported() -> None:
    found = population(MODEL, fleet(np.random.default_rng(4), units=2, each=1))
    assert found.groups == []
    assert found.cannot_tell == ["cube CUBE-1", "cube CUBE-2", "operator A. Miller"]
    text = population_text(found)
    assert "units: 2 are too few to find an outlier, 5 are needed" in text
    assert "it takes 3 units" in text


LIMITS = each_axis(Limit("accelerometer.bias", -2e-3, 2e-3, "g"))


@pytest.fixture(scope="module")
def pages() -> dict[int, str]:
    runs = {each: fleet(np.random.default_rng(2), units=1, each=each) for each in (1, 5)}
    return {each: unit_page(unit_history("S<0>", some, {MODEL: LIMITS})) for each, some in runs.items()}


@pytest.mark.parametrize("each", [1, 5])
def test_a_units_page_is_self_contained_and_has_a_chart_of_every_kind(pages: dict[int, str], each: int) -> None:
    text = pages[each]
    assert text.count("<svg") == 6
    assert not re.search(r'(src|href)="(?!#)', text)
    assert "S&lt;0&gt;" in text
    assert not re.search(r"\bnan\b", text)
    assert ("too few calibrations" in text) == (each == 1)


def test_a_populations_page_names_what_stands_out_in_its_charts() -> None:
    runs = fleet(np.random.default_rng(3), units=10, each=6, off_cube_ug=200.0, off_unit_ug=5000.0)
    found = population(MODEL, runs)
    json.dumps(document_of(found), allow_nan=False)
    text = population_page(found)
    figures = "".join(re.findall(r"<svg.*?</svg>", text, re.DOTALL))
    assert ">S2<" in figures
    assert ">CUBE-2<" in figures
    assert ">CUBE-1<" not in figures
