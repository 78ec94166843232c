"""The figures of reports against stored ones that were looked at: words as they are, numbers to 0.02 of a point.

After a change that is meant, ``--force-regen`` writes them again: look at them in a browser before they are kept.
"""

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from pytest_regressions.file_regression import FileRegressionFixture

from procedures.calibration.solution_values import StepResidual
from procedures.tolerance.drawing_items import ITEMS
from station.results.fixtures.tolerance_text import tolerance_svg
from station.results.history.history_page import population_svgs
from station.results.history.population import (
    GroupDeviation,
    Population,
    PopulationParameter,
    UnitDeviation,
    UnitValue,
)
from station.results.report.noise_document import (
    AllanCurve,
    MeanOutput,
    NoiseChannel,
    NoiseLine,
    SpectrumCurve,
    Term,
    TermBelow,
)
from station.results.report.noise_page import noise_svg
from station.results.report.report import residual_svg

NUMBER = re.compile(r"-?\d+\.\d+(?:e-?\d+)?|-?\d+")


def population() -> str:
    def track(median: float, values: list[float], off: str, spread: float | None) -> PopulationParameter:
        units = [UnitValue(f"S{i}", value, 0.5) for i, value in enumerate(values)]
        extremes = [UnitDeviation(0.0, 1.0, 1.0, serial, stands_out=serial == off) for serial in (off, "S0")]
        return PopulationParameter("1", median, spread, units, extremes)

    def group(i: int, shift: float) -> GroupDeviation:
        return GroupDeviation("cube", f"C{i}", "gyroscope.bias.x", "1", shift, 2.0, 0.5, 1.0, 3, stands_out=i == 7)

    parameters = {
        "accelerometer.scale_factor.x": track(1000.0, [999.0, 1001.5, 1030.0], "S2", 1.0),
        "gyroscope.bias.z": track(0.5, [0.5, -7.0, 1.0], "S1", None),
    }
    groups = [group(i, 3.0 * i - 8.0) for i in range(30)]
    found = Population("population/1", "M", 3, 3, 0.05, [], parameters, groups, [])
    charts = population_svgs(found)
    assert [heading for heading, *_ in charts] == ["Units", "Cubes, surface plates, sites, operators"]
    assert charts[1][1].startswith("Shifts in units of their uncertainty, the 25 least probable of 30.")
    assert len(population_svgs(replace(found, groups=[]))) == 1
    return "\n".join(svg for *_, svg in charts)


def residuals() -> str:
    def step(name: str, kind: str, position: int, *ratio: float) -> StepResidual:
        sigma = np.array([2.0, 4.0, 0.5])
        return StepResidual(name, kind, "gyroscope", position, np.array(ratio) * sigma, sigma, "deg/h")

    steps = [
        step("p1.csv", "dwell", 1, 0.5, -1.2, 2.2), step("p2.csv", "dwell", 2, -0.3, 0.1, -5.5),
        step("turn_x_plus.csv", "turn", 1, 1.0, 0.2, -0.4), step("turn_y_minus.mcap", "turn", 5, 0.1, 0.2, 0.3),
    ]  # fmt: skip
    assert residual_svg("accelerometer", steps) == ""
    calm = residual_svg("gyroscope", [step("p1.csv", "dwell", 1, 0.5, np.nan, 0.1)])
    return residual_svg("gyroscope", steps) + "\n" + calm


def tolerance() -> str:
    rng = np.random.default_rng(1)
    drawing = SimpleNamespace(cube="C", item=np.linspace(1e-4, 6e-4, len(ITEMS)), side_mm=100.0)
    found = SimpleNamespace(
        drawing=drawing, question=SimpleNamespace(wanted=2e-5), worst=np.linspace(1e-5, 9e-5, 21),
        sample=SimpleNamespace(bias=1e-5 * rng.normal(size=(3, 3, 400)) * [[[1.0]], [[2.0]], [[3.0]]]),
        allowed=[SimpleNamespace(item=name, allowed=2e-4 + 1e-5 * i) for i, name in enumerate(ITEMS)],
    )  # fmt: skip
    return tolerance_svg(cast(Any, found))


TAU = 2.0 ** np.arange(-2, 12)  # s


def of_terms(q: float, n: float, b: float, k: float, r: float) -> np.ndarray[Any, Any]:
    """Return the Allan deviation of quantisation, white noise, flicker, random walk, ramp: IEEE 952, annex C."""
    variance = 3 * (q / TAU) ** 2 + n**2 / TAU + b**2 * 2 * np.log(2) / np.pi + k**2 * TAU / 3 + (r * TAU) ** 2 / 2
    return np.sqrt(variance)


def channel(
    name: str, unit: str, deviation: np.ndarray[Any, Any], terms: dict[str, float], steep: bool = False
) -> NoiseChannel:
    hertz = np.geomspace(0.01, 50.0, 12)
    steepest = np.geomspace(30.5 ** (2 / 1.1), 1.0, 12)  # with margins its axis shows a little more than 30 times
    density = 4.0 * steepest if steep else 4.0 + 1 / hertz
    density[5] = 0.0
    low, high = (0.8 * deviation).tolist(), (1.3 * deviation).tolist()
    return NoiseChannel(
        name, "", 0.0, 0.0, MeanOutput(0.0, unit),
        {key: Term("", "", "", value) for key, value in terms.items()} | {"rate_ramp": TermBelow("", "", "", 1.0)},
        0.0, (), AllanCurve(TAU.tolist(), unit, TAU.tolist(), deviation.tolist(), low, high),
        SpectrumCurve(hertz.tolist(), density.tolist(), ""),
        [NoiseLine(at, 0.0, 0.0, 0.0, "", 0.0, 0.0) for at in (2.0, hertz[5])],
    )  # fmt: skip


def noise() -> str:
    g = 9.80665
    terms = {"quantisation": 2.0, "random_walk": 0.03, "bias_instability": 0.5, "rate_random_walk": 3.0}
    gyro = channel("gyroscope x", "deg/h", of_terms(2.0, 0.03 * 60, 0.5, 3.0 / 60, 0.0), terms)  # arcsec, deg/rt h
    accel = channel("accelerometer z", "ug", of_terms(50.0 / g, 40.0, 6.0, 12.0 / 60, 0.0),
                    steep=True, terms=terms | {"quantisation": 50.0, "random_walk": 40.0, "bias_instability": 6.0,
                             "rate_random_walk": 12.0})  # fmt: skip
    assert noise_svg("noise", []) == ""
    drawn = noise_svg("noise", [gyro, accel])
    width, height = re.findall(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', drawn)[0]
    assert (float(width), float(height)) == (7.0 * 72, 2 * 2.7 * 72)
    paths = [np.array(re.findall(r"[ML] ([\d.]+) ([\d.]+)", d), float) for d in re.findall(r' d="([^"]+)"', drawn)]
    measured_and_fitted = [path for path in paths if len(path) == len(TAU)]
    assert len(measured_and_fitted) == 4
    np.testing.assert_allclose(measured_and_fitted[0::2], measured_and_fitted[1::2], atol=1e-3)
    return drawn


FIGURES = {
    "noise": noise,
    "population": population,
    "residuals": residuals,
    "tolerance": tolerance,
}


def compare(drawn: Path, stored: Path) -> None:
    texts = [path.read_text(encoding="utf-8") for path in (drawn, stored)]
    assert NUMBER.sub("#", texts[0]) == NUMBER.sub("#", texts[1])
    numbers, kept = ([float(each) for each in NUMBER.findall(text)] for text in texts)
    np.testing.assert_allclose(numbers, kept, atol=0.02)


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_the_one_that_was_looked_at(name: str, file_regression: FileRegressionFixture) -> None:
    file_regression.check(FIGURES[name](), basename=name, extension=".svg", check_fn=compare, encoding="utf-8")
