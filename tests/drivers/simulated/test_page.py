"""The page on simulated devices says what the code does."""

import re

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import SimulatedBench
from drivers.simulated.effects import EFFECTS
from drivers.simulated.line_faults import CAN_KINDS, KINDS, load_faults
from drivers.simulated.timed_faults import CAMERA_KINDS
from drivers.simulated.truth import Truth, load_truth
from tests.paths import ROOT

PAGE = (ROOT / "docs/reference/simulated-devices.md").read_text(encoding="utf-8")


def test_the_example_file_is_a_truth_and_faults() -> None:
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    assert set(load_truth(text).effects) == {"accelerometer.quadratic", "placement.dwell"}
    assert [fault.kind for fault in load_faults(text)] == ["lost"]
    SimulatedBench(load_truth(text), 1)


ROWS = {row.split("`")[1]: row for row in PAGE.splitlines() if row.startswith("| `")}


def test_every_effect_with_options_has_its_row() -> None:
    for effect in (effect for effect in EFFECTS.values() if effect.options):
        options = ", ".join(f"{name} = {value:g}" for name, value in effect.options.items())
        for part in (effect.name, effect.unit, ", ".join(effect.keys), options):
            if part not in ROWS.get(effect.name, ""):
                pytest.fail(
                    f"{effect.name} has no {part!r} in a row of the page of simulated devices.", pytrace=False
                )


def test_every_key_of_a_truth_has_its_row_and_its_default() -> None:
    said = dict[str, str]()
    for row in PAGE.splitlines():
        keys = re.findall(r"`(\w+)`", row.split("|")[1]) if row.count("|") == 4 else []
        if keys and set(keys) <= set(Truth.__dataclass_fields__):
            defaults = row.split("|")[2].replace('"', "").split(",")
            said |= dict.fromkeys(keys, row.split("|")[2].strip())
            said |= {k: v.strip() for k, v in zip(keys, defaults, strict=False)} if len(keys) > 1 else {}
    assert set(said) == set(Truth.__dataclass_fields__)
    unit = Truth()
    for key, value in said.items():
        default = getattr(unit, key)
        if isinstance(default, float | str):
            assert value == (default if isinstance(default, str) else f"{default:g}"), key
    for key in ("accel_k", "gyro_k", "accel_d_g", "gyro_d_deg_s", "faces_rad", "slab_tilt_rad"):
        assert (getattr(unit, key) == float(said[key])).all()
    assert said["magnetic_enu_ut"] == ", ".join(f"{each:g}" for each in unit.magnetic_enu_ut)
    assert said["imu_axes"] == ", ".join(f'"{each}"' for each in unit.imu_axes)
    assert (unit.gravity_m_s2, len(unit.effects)) == (None, 0)
    assert (unit.accel_e == np.eye(3)).all()
    assert (unit.gyro_e == np.eye(3)).all()


def test_every_fault_has_its_row() -> None:
    assert {*KINDS, *CAN_KINDS, *CAMERA_KINDS} <= set(ROWS)
