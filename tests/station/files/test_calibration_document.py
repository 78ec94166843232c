"""A calibration/1 is applied in the units that the station writes; in any other it is refused in one line."""

from typing import Any

import pytest

from station.calibration import calibration_of
from station.errors import DataRefused
from tests.refusals import refused
from tests.station.calibrated.test_calibration_applied import effect
from tests.station.exports.every_effect import every_effect


def with_unit(path: tuple[str, str], unit: Any) -> dict[str, Any]:
    found = every_effect()
    found[path[0]][path[1]]["unit"] = unit
    return found


@pytest.mark.parametrize(
    ("path", "unit", "expected"),
    [
        (("accelerometer", "bias"), "ug", "'g'"), (("gyroscope", "bias"), "deg/s", "'deg/h'"),
        (("gyroscope", "bias"), None, "'deg/h'"), (("accelerometer", "misalignment"), "rad", "'1'"),
        (("gyroscope", "scale_factor"), "count/rad", "'count/deg' or 'output/(deg/s)'"),
        (("accelerometer", "scale_factor"), "count/deg", "'count/(g s)' or 'output/g'"),
        (("gyroscope", "scale_factor"), "output/(deg/s)", "count and output/(deg/s)"),
    ],
)  # fmt: skip
def test_a_triad_in_another_unit_is_refused(path: tuple[str, str], unit: Any, expected: str) -> None:
    with refused(DataRefused, None, expected):
        calibration_of(with_unit(path, unit))


@pytest.mark.parametrize(
    ("entry", "reported"),
    [
        (effect("accelerometer.quadratic", x=1.0) | {"unit": "ug/g^2"}, "'g/g^2'"),
        (effect("gyroscope.bias_temperature", x=1.0) | {"unit": "deg/s/K"}, "'deg/h/K'"),
        (
            effect("gyroscope.scale_nonlinearity", "u^3", x=1.0) | {"unit": "ppm/(deg/s)"},
            "'ppm/(deg/s)^2'",
        ),
        (effect("gyroscope.magnetic", x=1.0), "'x' of gyroscope.magnetic"),
        (effect("gyroscope.bias_temperature", **{"x.7": 1.0}), "'x.7' of gyroscope.bias_temperature"),
    ],
)
def test_an_effect_in_another_unit_or_of_other_coefficients_is_refused(
    entry: dict[str, Any], reported: str
) -> None:
    with refused(DataRefused, None, reported):
        calibration_of(every_effect(entry))


def test_what_the_station_writes_is_taken() -> None:
    units = {"accelerometer": ("count/(g s)", "g"), "gyroscope": ("count/deg", "deg/h")}
    found = every_effect(effect("accelerometer.quadratic", x=1e-5) | {"unit": "g/g^2"})
    for name, (scale, bias) in units.items():
        found[name]["scale_factor"]["unit"], found[name]["bias"]["unit"] = scale, bias
        found[name]["misalignment"]["unit"] = "1"
    assert calibration_of(found).output == "counts"
