"""An off unit and an off cube are named, each for what it is; a fleet with nothing off seldom shows anything."""

import json

import numpy as np
import pytest

from station.results.history.population import ALPHA, population_document
from station.results.history.population_text import population_text
from tests.station.results.history.fleets import MODEL, fleet


def named(document: dict[str, object]) -> tuple[set[str], set[str]]:
    units = {
        one["serial"]
        for track in document["parameters"].values()
        for one in track["extremes"]
        if one["stands_out"]
    }  # type: ignore[attr-defined]
    groups = {one["id"] for one in document["groups"] if one["stands_out"]}  # type: ignore[attr-defined]
    return units, groups


def test_a_fleet_with_nothing_off_seldom_shows_anything() -> None:
    rng, fleets = np.random.default_rng(1), 40
    alarms = sum(named(population_document(MODEL, fleet(rng))) != (set(), set()) for _ in range(fleets))
    assert alarms / fleets < ALPHA + 3 * np.sqrt(ALPHA * (1 - ALPHA) / fleets)


def test_an_off_cube_is_named_and_not_the_good_ones_it_is_compared_with() -> None:
    for seed in (2, 105, 141):  # in the last two the good cubes' shifts are the less scattered ones
        runs = fleet(np.random.default_rng(seed), units=10, each=6, off_cube_ug=200.0)
        document = population_document(MODEL, runs)
        assert named(document) == (set(), {"CUBE-2"})
    found = [one for one in document["groups"] if one["stands_out"]]
    assert {one["parameter"] for one in found} == {f"accelerometer.bias.{axis}" for axis in "xyz"}
    for one in found:
        assert abs(one["shift"] - 200e-6) < 4 * one["std"]
        assert one["units"] == 10


def test_an_off_unit_is_named_and_no_cube() -> None:
    runs = fleet(np.random.default_rng(3), units=12, off_unit_ug=1500.0)
    assert named(population_document(MODEL, runs)) == ({"S2"}, set())


def test_what_cannot_be_told_is_said() -> None:
    document = population_document(MODEL, fleet(np.random.default_rng(4), units=2, each=1))
    assert document["groups"] == []
    assert document["cannot_tell"] == ["cube CUBE-1", "cube CUBE-2", "operator A. Miller"]
    text = population_text(document)
    assert "units: 2 are too few to say that one stands out, 5 are needed" in text
    assert "it takes 3 units" in text


@pytest.mark.parametrize("units", [1, 12])
def test_its_text_fits_the_terminal_and_its_json_holds_no_nan(units: int) -> None:
    runs = fleet(np.random.default_rng(5), units=units, each=4, off_cube_ug=300.0, off_unit_ug=5000.0)
    document = population_document(MODEL, runs)
    json.dumps(document, allow_nan=False)
    assert max(map(len, population_text(document).splitlines())) <= 80
