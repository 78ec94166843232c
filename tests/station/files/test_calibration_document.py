"""A calibration/1 is applied in the units that the station writes; in any other it is refused in one line."""

from typing import Any

import pytest

from station.calibration import calibration_of
from station.errors import DataRefused
from tests.station.calibrated.test_calibration_applied import effect
from tests.station.exports.every_effect import every_effect


def with_unit(path: tuple[str, str], unit: Any) -> dict[str, Any]:
    found = every_effect()
    found[path[0]][path[1]]["unit"] = unit
    return found


@pytest.mark.parametrize(
    ("path", "unit", "said"),
    [
        (("accelerometer", "bias"), "ug", "found accelerometer.bias in 'ug', expected 'g'; convert it"),
        (("gyroscope", "bias"), "deg/s", "found gyroscope.bias in 'deg/s', expected 'deg/h'; convert it"),
        (("gyroscope", "bias"), None, "found gyroscope.bias in None, expected 'deg/h'; convert it"),
        (("accelerometer", "misalignment"), "rad", "found accelerometer.misalignment in 'rad', expected '1'"),
        (("gyroscope", "scale_factor"), "count/rad", "in 'count/rad', expected 'count/deg' or 'output/(deg/s)'"),
        (("accelerometer", "scale_factor"), "count/deg", "expected 'count/(g s)' or 'output/g'; convert it"),
        (("gyroscope", "scale_factor"), "output/(deg/s)", "found scale factors in count and output/(deg/s)"),
    ],
)  # fmt: skip
def test_a_triad_in_another_unit_is_refused(path: tuple[str, str], unit: Any, said: str) -> None:
    with pytest.raises(DataRefused) as refused:
        calibration_of(with_unit(path, unit))
    assert said in str(refused.value)


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        (effect("accelerometer.quadratic", x=1.0) | {"unit": "ug/g^2"}, "in 'ug/g^2', expected 'g/g^2'"),
        (effect("gyroscope.bias_temperature", x=1.0) | {"unit": "deg/s/K"}, "expected 'deg/h/K'"),
        (
            effect("gyroscope.scale_nonlinearity", "u^3", x=1.0) | {"unit": "ppm/(deg/s)"},
            "expected 'ppm/(deg/s)^2'",
        ),
        (effect("gyroscope.magnetic", x=1.0), "coefficient 'x' of gyroscope.magnetic, expected xx, xy"),
        (effect("gyroscope.bias_temperature", **{"x.7": 1.0}), "coefficient 'x.7' of gyroscope.bias_temperature"),
    ],
)
def test_an_effect_in_another_unit_or_of_other_coefficients_is_refused(entry: dict[str, Any], said: str) -> None:
    with pytest.raises(DataRefused) as refused:
        calibration_of(every_effect(entry))
    assert said in str(refused.value)


def test_what_the_station_writes_is_taken() -> None:
    units = {"accelerometer": ("count/(g s)", "g"), "gyroscope": ("count/deg", "deg/h")}
    found = every_effect(effect("accelerometer.quadratic", x=1e-5) | {"unit": "g/g^2"})
    for name, (scale, bias) in units.items():
        found[name]["scale_factor"]["unit"], found[name]["bias"]["unit"] = scale, bias
        found[name]["misalignment"]["unit"] = "1"
    assert calibration_of(found).output == "counts"
