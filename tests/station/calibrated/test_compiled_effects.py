"""What kernels correct is what plain numpy says that an effect adds: every effect that one sample determines."""

from typing import Any

import numpy as np
import pytest

from procedures.arrays import FloatArray
from procedures.effects import CATALOGUE, EFFECTS
from procedures.effects.excitation import PLAY, TAU
from station.calibrated.applied_calibration import CalibrationModel
from station.calibrated.correction_inputs import (
    DIRECTION,
    RATE,
    WARMTH,
    Backlash,
    Surroundings,
    TemperatureFollower,
)
from tests.procedures.effects.laws_by_hand import BY_HAND, ORDER, Felt
from tests.station.calibrated.test_calibration_applied import calibration, effect

N = 500
DRAW = np.random.default_rng(8)
TAU_S, PLAY_K = 37.0, 1.3
SIZES = {"gyroscope.sagnac_sine": 4e-3, "accelerometer.cross_product": 2e-4, "gyroscope.scale_nonlinearity": 3.0}
CASES = [key for key in BY_HAND if not CATALOGUE[key[0]].not_corrected]
ITERATED = ("temperature_rate_lag",)  # a difference of two signals, for which the kernel has no array
ALWAYS_LEFT = (
    "bias_drift",
    "bias_settling",
    "bias_cycle",
    "scale_settling",
    "relaxation",
    "counts_lost",
    "vibration_rectification",
)


def entry_of(name: str, shape: str) -> dict[str, Any]:
    one = CATALOGUE[name]
    law = one.law(shape)
    assert law is not None
    size = SIZES.get(name, one.plausible)
    keys = law.keys((ORDER, 1, 2)) if law.is_polynomial else law.coefficients
    values = {
        key: size * (1 + 0.3 * i) * (-1) ** i * 30.0 ** (1 - int(key[2:]) if "." in key else 0)
        for i, key in enumerate(keys)
    }
    return effect(name, shape, **values, **{key: {TAU: TAU_S, PLAY: PLAY_K}[key] for key in law.parameters})


def added_by_hand(entry: dict[str, Any], felt: Felt) -> FloatArray:
    """What an entry adds (n, 3) to its triad."""
    name = str(entry["name"])
    values = {key: one["value"] for key, one in entry["coefficients"].items() if key not in (TAU, PLAY)}
    if name == "gyroscope.sagnac_sine":
        s = np.array([values[axis] for axis in "xyz"])
        return np.where(s > 0, np.sin(s * felt.u), np.sinh(s * felt.u)) / s - felt.u
    value = BY_HAND[name, entry.get("shape", "")](felt)
    if any("." in key for key in values):
        return sum(
            value[:, :, int(key[2:]) - 1] * c * (np.arange(3) == "xyz".index(key[0])) for key, c in values.items()
        )
    table = np.array(list(values.values())).reshape(3, -1)
    return np.asarray((value[:, :, : table.shape[1]] * table).sum(axis=2))


def around() -> tuple[Surroundings, FloatArray, FloatArray]:
    t = np.cumsum(DRAW.uniform(0.5, 1.5, N))
    T = 25 + np.cumsum(DRAW.normal(0, 0.3, N))
    signals = TemperatureFollower((TAU_S, Backlash(PLAY_K))).take(t, T)
    f, omega = DRAW.uniform(-3, 3, (N, 3)), DRAW.uniform(-150, 150, (N, 3))
    return Surroundings(magnetic=DRAW.normal(0, 40, (N, 3)), t=t, signals=signals), f, omega


@pytest.mark.parametrize(("name", "shape"), CASES)
def test_a_kernel_corrects_what_an_effect_adds(name: str, shape: str) -> None:
    entry = entry_of(name, shape)
    model = CalibrationModel.of(calibration(entry))
    assert [one.is_compiled for one in model.effects] == [name.partition(".")[2] not in ITERATED]
    here, f, omega = around()
    triad, signals = name.partition(".")[0], here.followed
    u = {"accelerometer": f, "gyroscope": omega}
    output = {each: u[each] @ of.E.T + of.D for each, of in model.triads.items()}
    assert here.magnetic is not None
    felt = Felt(
        u[triad], output[triad], f, here.magnetic, signals[WARMTH], signals[RATE], signals[TAU_S],
        signals[DIRECTION], signals[Backlash(PLAY_K)], tau=TAU_S,
    )  # fmt: skip
    added = added_by_hand(entry, felt)
    assert np.abs(added).max() > 1e-6  # else nothing was planted
    output[triad] = output[triad] + added
    accel, gyro = (output[each] * model.triads[each].k for each in ("accelerometer", "gyroscope"))
    found = model.inputs(accel, gyro, here)
    assert found.not_applied == ()
    assert found.f == pytest.approx(f, abs=1e-12)
    assert found.omega == pytest.approx(omega, abs=1e-10)


def test_what_is_never_corrected_says_so_in_its_record() -> None:
    left = {one.name.partition(".")[2] for one in EFFECTS if one.laws and one.not_corrected}
    assert left >= set(ALWAYS_LEFT)
    assert all(one.not_corrected for one in EFFECTS if not one.laws)
