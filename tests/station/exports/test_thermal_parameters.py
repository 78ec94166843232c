"""What flight stacks make of the temperature with what is exported, by their formulas, written here once more."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from procedures.units import RAD_PER_DEG, STANDARD_GRAVITY
from station.exports import EXPORTS, Request
from station.exports.flight_stacks import ARDUPILOT, MAX_NAME, PX4
from tests.station.calibrated.test_calibration_applied import D_A, D_G, K_A, K_G, calibration, effect
from tests.station.exports.every_effect import every_effect, with_facts

ACCEL = effect(
    "accelerometer.bias_temperature", **{"x.1": 1e-4, "x.2": -3e-6, "x.3": 2e-8, "y.1": 5e-5, "z.1": -4e-5}
)
GYRO = effect("gyroscope.bias_temperature", **{"x.1": 3.0, "y.1": -2.0, "y.2": 0.1, "z.3": 1e-3})
NOMINAL = (1000.0, 36000.0)
Correct = Callable[[np.ndarray, np.ndarray, float], tuple[np.ndarray, np.ndarray]]


def document(*effects: dict[str, Any], limits: tuple[float, float] | None = (5.0, 45.0)) -> dict[str, Any]:
    found = with_facts(calibration(*effects))
    for name, unit in (("accelerometer", "count/(g s)"), ("gyroscope", "count/deg")):
        found[name]["misalignment"]["value"] = np.eye(3).tolist()
        found[name]["scale_factor"]["unit"] = unit
    return found if limits is None else {**found, "temperature_range_c": list(limits)}


def exported(folder: Path, name: str, document: dict[str, Any]) -> str:
    (folder / "c.json").write_text(json.dumps(document))
    export = next(one for one in EXPORTS if one.name == name)
    (content,) = export.files(Request(folder / "c.json", *NOMINAL)).values()
    return content.decode()


def values_of(text: str) -> dict[str, np.float32]:
    rows = [re.split(r"[,\t]", line) for line in text.splitlines() if line and not line.startswith("#")]
    return {row[0] if len(row) == 2 else row[2]: np.float32(row[1 if len(row) == 2 else 3]) for row in rows}


def as_px4(text: str) -> Correct:
    value = values_of(text)

    def offset(letter: str, T: float) -> np.ndarray:
        clipped = min(max(T, float(value[f"TC_{letter}0_TMIN"])), float(value[f"TC_{letter}0_TMAX"]))
        delta = clipped - float(value[f"TC_{letter}0_TREF"])
        return sum(np.array([value[f"TC_{letter}0_X{n}_{i}"] for i in range(3)]) * delta**n for n in range(4))

    accel, gyro, scale = (
        np.array([value[f"CAL_{kind}".format(axis)] for axis in "XYZ"])
        for kind in ("ACC0_{}OFF", "GYRO0_{}OFF", "ACC0_{}SCALE")
    )
    assert value["TC_A_ENABLE"] == value["TC_G_ENABLE"] == 1
    return lambda a, g, T: ((a - offset("A", T) - accel) * scale, g - offset("G", T) - gyro)


def as_ardupilot(text: str) -> Correct:
    value = values_of(text)

    def polynomial(kind: str, T: float) -> np.ndarray:
        d = min(max(T, float(value["INS_TCAL1_TMIN"])), float(value["INS_TCAL1_TMAX"])) - 35.0
        c = [np.array([value[f"INS_TCAL1_{kind}{n}_{axis}"] for axis in "XYZ"]) for n in (1, 2, 3)]
        return (c[0] + (c[1] + c[2] * d) * d) * d * 1e-6

    def of(kind: str, T: float) -> np.ndarray:
        return polynomial(kind, T) - polynomial(kind, float(value[f"INS_{kind}1_CALTEMP"]))

    accel, gyro, scale = (
        np.array([value[f"INS_{kind}_{axis}"] for axis in "XYZ"]) for kind in ("ACCOFFS", "GYROFFS", "ACCSCAL")
    )
    assert value["INS_TCAL1_ENABLE"] == 1
    return lambda a, g, T: ((a - of("ACC", T) - accel) * scale, g - of("GYR", T) - gyro)


STACKS = {"px4": as_px4, "ardupilot": as_ardupilot}
every_stack = pytest.mark.parametrize("stack", STACKS)


def raw(T: float, accel: np.ndarray, gyro: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what a driver reads (m/s2, rad/s) at no input, with offsets that go with the temperature added."""
    return (
        K_A / NOMINAL[0] * (D_A + accel) * STANDARD_GRAVITY,
        K_G / NOMINAL[1] * (D_G / 3600 + gyro) * RAD_PER_DEG,
    )


@every_stack
@pytest.mark.parametrize("limits", [(5.0, 45.0), (30.0, 60.0), (-40.0, 10.0)])
def test_a_cubic_of_the_offset_is_taken_off(stack: str, limits: tuple[float, float], tmp_path: Path) -> None:
    correct = STACKS[stack](exported(tmp_path, stack, document(ACCEL, GYRO, limits=limits)))
    for T in np.linspace(*limits, 9):
        w = T - 25.0
        a = np.array([1e-4 * w - 3e-6 * w**2 + 2e-8 * w**3, 5e-5 * w, -4e-5 * w])
        g = np.array([3.0 * w, -2.0 * w + 0.1 * w**2, 1e-3 * w**3]) / 3600
        force, rate = correct(*raw(T, a, g), float(T))
        assert np.abs(force).max() < 1e-6 * STANDARD_GRAVITY  # of float's digits; the offset is up to 16 mg
        assert np.abs(rate).max() < 1e-3 * RAD_PER_DEG / 3600


@every_stack
def test_beyond_the_third_order_the_error_is_what_is_stated(stack: str, tmp_path: Path) -> None:
    fifth = effect("accelerometer.bias_temperature", **{"x.1": 1e-5, "x.5": 1e-10, "y.1": 0.0, "z.1": 0.0})
    text = exported(tmp_path, stack, document(fifth, GYRO))
    reported = re.search(r"accelerometer offset beyond the third order: up to (\S+) m/s2", text)
    assert reported is not None
    correct = STACKS[stack](text)
    errors = []
    for T in np.linspace(5.0, 45.0, 81):
        w = T - 25.0
        force, _ = correct(*raw(T, np.array([1e-5 * w + 1e-10 * w**5, 0, 0]), np.zeros(3)), float(T))
        errors.append(abs(force[0]))
    assert max(errors) == pytest.approx(float(reported[1]), rel=0.05)
    assert max(errors) < 1e-10 * 20**5 * STANDARD_GRAVITY / 10  # a cubic takes most of it


@every_stack
def test_what_lags_is_taken_at_rest_in_temperature(stack: str, tmp_path: Path) -> None:
    lag = effect("accelerometer.temperature_lag", x=1e-4, y=0.0, z=0.0, tau_s=600.0)
    text = exported(tmp_path, stack, document(lag, GYRO))
    g = np.array([30.0, -20.0 + 10.0, 1.0]) / 3600
    force, _ = STACKS[stack](text)(*raw(35.0, np.array([1e-3, 0, 0]), g), 35.0)
    assert np.abs(force).max() < 1e-6 * STANDARD_GRAVITY
    reported = re.search(r"accelerometer offset lags behind the thermometer: up to (\S+) m/s2 at 1 K/min", text)
    assert reported is not None
    assert float(reported[1]) == pytest.approx(1e-4 * 10 * 1.01 * STANDARD_GRAVITY, rel=0.05)  # 600 s are 10 min


@every_stack
def test_without_temperatures_there_is_no_table(stack: str, tmp_path: Path) -> None:
    text = exported(tmp_path, stack, document(ACCEL, GYRO, limits=None))
    assert not [name for name in values_of(text) if "TC" in name]
    assert "NOT CARRIED: accelerometer.bias_temperature, up to" in text
    assert not [name for name in values_of(exported(tmp_path, stack, document())) if "TC" in name]


@every_stack
def test_every_parameter_is_on_the_stacks_own_list(stack: str, tmp_path: Path) -> None:
    listed = {"px4": PX4, "ardupilot": ARDUPILOT}[stack]
    known = document(ACCEL, GYRO)
    for value in (
        known,
        {**every_effect(), "accelerometer": known["accelerometer"], "gyroscope": known["gyroscope"]},
    ):
        found = values_of(exported(tmp_path, stack, value))
        assert set(found) <= set(listed)
        assert all(len(name) <= MAX_NAME for name in found)
        assert all(listed[name].low <= one <= listed[name].high for name, one in found.items())
    unused = set(listed) - set(values_of(exported(tmp_path, stack, known)))
    assert not unused
