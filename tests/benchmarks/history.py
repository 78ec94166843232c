"""Print how far the statements of `station history` can be trusted.

`python -m tests.benchmarks.history`: the coverage of 95 % prediction intervals, the alarms of the control chart on
steady units, and how often an off unit or cube is named, and in a fleet where nothing is off.
"""

import argparse

import numpy as np

from procedures.history.control_chart import MIN_EARLIER, control_chart, control_limit
from procedures.history.parameter_series import CalibrationSeries
from procedures.history.prediction import forecast
from station.results.history.population import population_document
from tests.procedures.history.worlds import WORLDS
from tests.station.results.history.fleets import MODEL, fleet

RUNS = (3, 4, 6, 10, 20)


def coverage(units: int) -> None:
    print(f"95 % prediction a year ahead, {units} units each: share covered")
    print(f"  {'':22}" + "".join(f"{f'{n} turn-ons':>16}" for n in RUNS))
    for name, world in WORLDS.items():
        cells = ""
        for n in RUNS:
            rng, hits = np.random.default_rng(n), 0
            for _ in range(units):
                series, day, truth = world.unit(n, rng)
                found = forecast(series)
                assert found is not None
                predicted = found.at(day)
                hits += predicted.low_95 <= truth <= predicted.high_95
            cells += f"{hits / units:>16.3f}"
        print(f"  {name:22}{cells}", flush=True)


def false_alarms(units: int, parameters: int = 24, runs: int = 10) -> None:
    print(
        f"control charts of {units} steady units, {parameters} parameters: alarms per calibration (asked: 0.010)"
    )
    limit = control_limit(parameters)
    for turn_on in (0.0, 1.0, 30.0):
        rng, alarms = np.random.default_rng(1), np.zeros(2)
        for _ in range(units):
            seen = np.zeros((2, runs - MIN_EARLIER), dtype=bool)
            for _ in range(parameters):
                std = rng.uniform(0.5, 2.0, runs)
                value = turn_on * rng.standard_normal(runs) + std * rng.standard_normal(runs)
                chart = control_chart(CalibrationSeries(100.0 * np.arange(runs), value, std), limit)
                assert chart is not None
                seen |= np.abs([chart.z, chart.ewma / chart.ewma_std]) > limit
            alarms += seen.sum(axis=1)
        z, ewma = alarms / units / (runs - MIN_EARLIER)
        print(f"  turn-on scatter {turn_on:4g} times sigma: individuals {z:.4f}, EWMA {ewma:.4f}", flush=True)


def populations(fleets: int) -> None:
    print(f"{fleets} fleets of 8 units, 4 turn-ons on 3 cubes; unit scatter 100, walk 5, turn-on 10 ug")
    for cube, unit in ((0, 0), (20, 0), (40, 0), (80, 0), (0, 500), (0, 1000), (0, 2000)):
        named, wrong = 0, 0
        for seed in range(fleets):
            runs = fleet(np.random.default_rng(seed), off_cube_ug=cube, off_unit_ug=unit)
            document = population_document(MODEL, runs)
            units = {
                one["serial"]
                for x in document["parameters"].values()
                for one in x["extremes"]
                if one["stands_out"]
            }
            groups = {one["id"] for one in document["groups"] if one["stands_out"]}
            named += (not cube or "CUBE-2" in groups) and (not unit or "S2" in units)
            wrong += bool(units - ({"S2"} if unit else set())) or bool(groups - ({"CUBE-2"} if cube else set()))
        found = f"named {named / fleets:.3f}, " if cube or unit else ""
        print(
            f"  cube off {cube:4d} ug, unit off {unit:4d} ug: {found}something else {wrong / fleets:.3f}",
            flush=True,
        )


def main() -> None:
    """Print all three."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--units", type=int, default=200)
    units = parser.parse_args().units
    coverage(units)
    false_alarms(units)
    populations(max(units // 4, 20))


if __name__ == "__main__":
    main()
