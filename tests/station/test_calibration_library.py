"""The library: what `apply` gives, that parts give the same as the whole, and what is promised."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from station.calibration import Calibration, DataRefused, calibration_of, load
from tests.refusals import refused
from tests.station.calibrated.test_calibration_applied import (
    D_A,
    D_G,
    E_A,
    E_G,
    K_A,
    K_G,
    calibration,
    effect,
)  # fmt: skip

G, PERIOD, N = 9.80665, 0.01, 20_000
DRAW = np.random.default_rng(3)
F, OMEGA = DRAW.uniform(-1, 1, (N, 3)), DRAW.uniform(-200, 200, (N, 3))
T_S = PERIOD * np.arange(1, N + 1)
T_C = 30 + 15 * np.sin(T_S / 40)
LAGGED = effect("gyroscope.temperature_lag", x=3.0, y=-2.0, z=1.0, tau_s=30.0)
EFFECTS = (
    effect("accelerometer.quadratic", x=6e-5, y=-4e-5, z=2e-5), effect("gyroscope.g_sensitivity", xz=0.7, yy=-0.3),
    effect("accelerometer.scale_temperature", x=20.0, y=30.0, z=-10.0), LAGGED,
    effect("gyroscope.temperature_hysteresis", x=0.5, y=0.5, z=0.5),
    effect("gyroscope.temperature_rate", x=1.0, y=-1.0, z=2.0),
)  # fmt: skip


def document(*effects: dict[str, Any]) -> dict[str, Any]:
    found = calibration(*effects) | {"model": "X", "serial": "S1", "temperature_range_c": [10.0, 50.0]}
    units = {"accelerometer": "count/(g s)", "gyroscope": "count/deg"}
    for name, unit in units.items():
        found[name]["scale_factor"]["unit"] = unit
    return found


def loaded(tmp_path: Path, *effects: dict[str, Any]) -> Calibration:
    file = tmp_path / "calibration.json"
    file.write_text(json.dumps(document(*effects)))
    return load(file)


def counts() -> np.ndarray:
    """What samples would count, not rounded."""
    gyro, accel = K_G * (OMEGA @ E_G.T + D_G / 3600), K_A * (F @ E_A.T + D_A)
    return np.hstack((gyro, accel)) * PERIOD


def test_counts_become_specific_force_and_rate_in_si(tmp_path: Path) -> None:
    found = loaded(tmp_path).apply(counts(), T_S)
    assert found.specific_force == pytest.approx(F * G, abs=1e-10)
    assert found.angular_rate == pytest.approx(np.radians(OMEGA), abs=1e-10)
    assert found.warnings == ()


@pytest.mark.parametrize("size", [1, 999])
def test_part_by_part_it_is_what_it_is_at_once(tmp_path: Path, size: int) -> None:
    known, values, n = loaded(tmp_path, *EFFECTS), counts(), 1500 if size == 1 else N
    whole = known.apply(values[:n], T_S[:n], T_C[:n], period=PERIOD)
    stream, parts = known.stream(PERIOD), []
    for i in range(0, n, size):
        part = slice(i, min(i + size, n))
        parts.append(stream.apply(values[part], T_S[part], T_C[part], last=part.stop == n))
    for name in ("specific_force", "angular_rate", "spans", "specific_force_std", "angular_rate_std"):
        together = np.concatenate([getattr(part, name) for part in parts])
        assert together == pytest.approx(getattr(whole, name), rel=1e-12, abs=1e-12), name
    assert parts[-1].warnings == whole.warnings == ()


def test_what_an_effect_lacks_is_reported_with_its_size(tmp_path: Path) -> None:
    found = loaded(tmp_path, LAGGED).apply(counts(), T_S)
    # 3 deg/h/K at 25 K from 25 degC
    (reported,) = found.warnings
    assert "75 deg/h" in reported
    assert loaded(tmp_path, LAGGED).without("gyroscope.temperature_lag").apply(counts(), T_S).warnings == ()


SINE = effect("gyroscope.sagnac_sine", x=2e-3, y=2e-3, z=2e-3)  # no rate puts out more than 1 / 2e-3 deg/s


def wild(at: list[int], rate: float = 700.0) -> np.ndarray:
    """Counts with some samples of a rate that a Sagnac sine never puts out."""
    found = counts().copy()
    found[at, 2] = K_G[2] * rate * PERIOD
    return found


@pytest.mark.parametrize("others", [(), (EFFECTS[1],)])
def test_a_sample_that_does_not_settle_is_nan_and_reported(
    tmp_path: Path, others: tuple[dict[str, Any], ...]
) -> None:
    calm, at = loaded(tmp_path, SINE, *others).apply(counts(), T_S), [70, 16_500]
    found = loaded(tmp_path, SINE, *others).apply(wild(at), T_S)
    rest = np.delete(np.arange(N), at)
    assert np.isnan(found.angular_rate[at]).all()
    assert np.array_equal(found.angular_rate[rest], calm.angular_rate[rest])
    assert np.array_equal(found.specific_force, calm.specific_force)
    assert found.angular_rate_std == pytest.approx(calm.angular_rate_std, rel=1e-2)
    names = ", ".join(each["name"] for each in (SINE, *others))
    (reported,) = found.warnings
    assert all(value in reported for value in (names, "2 of 20000 samples", "0.71 s"))


def test_more_than_one_in_a_thousand_that_do_not_settle_are_refused(tmp_path: Path) -> None:
    known = loaded(tmp_path, SINE)
    assert "20 of 20000" in known.apply(wild(list(range(20))), T_S).warnings[0]
    with refused(DataRefused, None, "gyroscope.sagnac_sine", "21 of 20000 samples"):
        known.apply(wild(list(range(21))), T_S)
    stream = known.stream(PERIOD)
    stream.apply(wild(list(range(21))), T_S)  # in parts the end decides
    with refused(DataRefused, None, "21 of 20000 samples"):
        stream.apply(np.empty((0, 6)), [], last=True)


SIX = np.ones((4, 6))
GIVEN: dict[str, Any] = {"counts": SIX, "t": [1.0, 2.0, 3.0, 4.0]}


@pytest.mark.parametrize(
    "changed",
    [
        {"counts": SIX.astype(object)}, {"counts": [[1.0], [1.0, 2.0]]}, {"t": ["a", "b", "c", "d"]},
        {"temperature": ["warm"] * 4}, {"magnetic": [["x"] * 3] * 4}, {"auxiliary": [1.0]}, {"frame": 5},
        {"axes": 5, "frame": "frd"}, {"period": "1"}, {"output": 5},
    ],
)  # fmt: skip
def test_what_is_no_array_of_numbers_is_refused_by_its_name(tmp_path: Path, changed: dict[str, Any]) -> None:
    name = next(iter(changed)) if "output" not in changed else "5"
    with refused(DataRefused, None, name):
        loaded(tmp_path).apply(**GIVEN | changed)


def test_what_is_no_calibration_at_all_is_refused() -> None:
    for given in (5, [], None):
        with pytest.raises(DataRefused):
            load(given)  # type: ignore[arg-type]
        with pytest.raises(DataRefused):
            calibration_of(given)  # type: ignore[arg-type]
