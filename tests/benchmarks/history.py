"""How far the statements of `station history` can be trusted.

The coverage of 95 % prediction intervals, the alarms of the control chart on steady units, and how often an off
unit or cube is named, and in a fleet where nothing is off.
"""

import numpy as np

from procedures.history.control_chart import MIN_EARLIER, control_chart, control_limit
from procedures.history.parameter_series import CalibrationSeries
from procedures.history.prediction import forecast
from station.results.history.population import population_document
from tests.procedures.history.worlds import WORLDS
from tests.proof.evidence import Figure
from tests.station.results.history.fleets import MODEL, fleet

RUNS = (4, 10)  # calibrations of a unit
PARAMETERS = 24


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return coverage and false alarms over ``size`` units, and the names found in a quarter as many fleets."""
    result = dict[str, Figure]()
    for name, world in WORLDS.items():
        for n in RUNS:
            rng, hits = np.random.default_rng([seed, n]), 0
            for _ in range(size):
                series, day, truth = world.unit(n, rng)
                found = forecast(series)
                assert found is not None
                predicted = found.at(day)
                hits += predicted.low_95 <= truth <= predicted.high_95
            result[f"95 % prediction a year ahead, {name}, {n} calibrations"] = Figure(100 * hits / size, "%")
    for turn_on in (0.0, 1.0, 30.0):
        alarms = false_alarms(turn_on, size, seed)
        title = f"control chart, steady units, turn-on scatter {turn_on:g} sigma: alarms per calibration"
        result[title] = Figure(100 * alarms, "%", at_most=2.0)
    for cube, unit in ((0, 0), (40, 0), (80, 0), (0, 1000)):
        named, wrong = populations(cube, unit, max(size // 4, 20), seed)
        if cube or unit:
            result[f"cube off {cube} ug, unit off {unit} ug: named"] = Figure(100 * named, "%")
        result[f"cube off {cube} ug, unit off {unit} ug: something else named"] = Figure(100 * wrong, "%")
    return result


def false_alarms(turn_on: float, units: int, seed: int, runs: int = 10) -> float:
    """Return the alarms of individuals and EWMA per calibration of steady units."""
    limit, rng, alarms = control_limit(PARAMETERS), np.random.default_rng(seed), 0
    for _ in range(units):
        seen = np.zeros(runs - MIN_EARLIER, dtype=bool)
        for _ in range(PARAMETERS):
            std = rng.uniform(0.5, 2.0, runs)
            value = turn_on * rng.standard_normal(runs) + std * rng.standard_normal(runs)
            chart = control_chart(CalibrationSeries(100.0 * np.arange(runs), value, std), limit)
            assert chart is not None
            seen |= (np.abs(chart.z) > limit) | (np.abs(chart.ewma / chart.ewma_std) > limit)
        alarms += int(seen.sum())
    return alarms / units / (runs - MIN_EARLIER)


def populations(cube: int, unit: int, fleets: int, seed: int) -> tuple[float, float]:
    """Return how often an off cube or unit [ug] was named, and how often something else, of 8 units on 3 cubes."""
    named = wrong = 0
    for number in range(fleets):
        runs = fleet(np.random.default_rng([seed, number]), off_cube_ug=cube, off_unit_ug=unit)
        document = population_document(MODEL, runs)
        units = {
            one["serial"] for x in document["parameters"].values() for one in x["extremes"] if one["stands_out"]
        }
        groups = {one["id"] for one in document["groups"] if one["stands_out"]}
        named += (not cube or "CUBE-2" in groups) and (not unit or "S2" in units)
        wrong += bool(units - ({"S2"} if unit else set())) or bool(groups - ({"CUBE-2"} if cube else set()))
    return named / fleets, wrong / fleets
