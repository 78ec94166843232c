"""What kernels take off is what the catalogue's columns add: every effect of the instrument that has that form."""

from typing import Any

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.effects import EFFECTS
from procedures.effects.effect import PLAY, TAU
from station.calibrated.applied_calibration import CalibrationModel
from station.calibrated.applied_effects import LOST, TRANSIENT_EFFECTS, added_by, excitation, is_compiled
from station.calibrated.correction_inputs import Surroundings, TemperatureFollower
from tests.station.calibrated.test_calibration_applied import calibration, effect

N = 500
DRAW = np.random.default_rng(8)
TAU_S = 37.0
OF_CAMPAIGN = tuple(
    f"{triad}.{name}" for triad in ("accelerometer", "gyroscope") for name in ("jump", "vibration_rectification")
)
PLAY_K = 1.3
SHAPES = {"gyroscope.scale_nonlinearity": ("u |u|", "u^3")} | {
    f"{triad}.temperature_hysteresis": ("", "with a play") for triad in ("accelerometer", "gyroscope")
}
SIZES = {"gyroscope.sagnac_sine": 4e-3, "accelerometer.cross_product": 2e-4, "gyroscope.scale_nonlinearity": 3.0}
MATRICES = {
    "gyroscope.g_sensitivity": ("xx", "xy", "yz", "zx"),
    "gyroscope.magnetic": ("xx", "xz", "yy", "zy"),
    "accelerometer.cross_product": ("xxy", "xyz", "yxz", "zyz"),
}
STAYS = (*TRANSIENT_EFFECTS, *LOST)
# a scatter has no value to take off
INSTRUMENT = [
    each for each in EFFECTS if each.kind == "instrument" and each.name not in STAYS and not each.is_scatter
]
CASES = [
    (each.name, shape)
    for each in INSTRUMENT
    if each.name not in OF_CAMPAIGN
    for shape in SHAPES.get(each.name, ("",))
]


def entry_of(name: str, shape: str) -> dict[str, Any]:
    size = SIZES.get(name, next(each for each in EFFECTS if each.name == name).plausible)
    keys: tuple[str, ...] = MATRICES.get(name, ("x", "y", "z"))
    if name.endswith(("bias_temperature", "temperature_lag", "scale_temperature")):
        keys = ("x.1", "x.2", "x.3", "z.1")
    values = {key: size * (1 + 0.3 * i) * (-1) ** i * 30.0 ** (1 - int(key[2:] or 1) if "." in key else 0)
              for i, key in enumerate(keys)}  # fmt: skip
    beside = {TAU: TAU_S} if name.endswith("_lag") else {PLAY: PLAY_K} if shape == "with a play" else {}
    return effect(name, shape, **values, **beside)


def around() -> tuple[Surroundings, FloatArray, FloatArray]:
    t = np.cumsum(DRAW.uniform(0.5, 1.5, N))
    T = 25 + np.cumsum(DRAW.normal(0, 0.3, N))
    signals = TemperatureFollower((TAU_S,), (PLAY_K,)).take(t, T)
    f, omega = DRAW.uniform(-3, 3, (N, 3)), DRAW.uniform(-150, 150, (N, 3))
    return Surroundings(magnetic=DRAW.normal(0, 40, (N, 3)), t=t, signals=signals), f, omega


@pytest.mark.parametrize(("name", "shape"), CASES)
def test_a_kernel_takes_off_what_the_columns_add(name: str, shape: str) -> None:
    entry = entry_of(name, shape)
    assert is_compiled(entry)
    model = CalibrationModel.of(calibration(entry))
    here, f, omega = around()
    u = {"accelerometer": f, "gyroscope": omega}
    seen = excitation(model.triads, u, here, N)
    added = added_by(entry, seen)
    output = {each: u[each] @ triad.E.T + triad.D + added.get(each, 0.0) for each, triad in model.triads.items()}
    accel, gyro = (output[each] * model.triads[each].k for each in ("accelerometer", "gyroscope"))
    found = model.inputs(accel, gyro, here)
    assert found.not_applied == ()
    assert sum(np.abs(part).max() for part in added.values()) > 1e-6  # else nothing was planted
    assert found.f == pytest.approx(f, abs=1e-12)
    assert found.omega == pytest.approx(omega, abs=1e-10)


def test_every_effect_of_the_instrument_is_either_compiled_or_of_the_campaign() -> None:
    assert {each.name for each in INSTRUMENT} == {name for name, _ in CASES} | set(OF_CAMPAIGN)
