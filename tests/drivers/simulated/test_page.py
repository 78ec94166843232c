"""The page on simulated devices says what the code does."""

import re

import pytest

from drivers.simulated.bench_in_memory import SimulatedBench
from drivers.simulated.effects import EFFECTS
from drivers.simulated.line_faults import CAN_KINDS, KINDS, load_faults
from drivers.simulated.timed_faults import CAMERA_KINDS
from drivers.simulated.truth import load_truth
from tests.paths import ROOT

PAGE = (ROOT / "docs/simulated-devices.md").read_text(encoding="utf-8")


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
                pytest.fail(f"{effect.name} has no {part!r} in a row of docs/simulated-devices.md.", pytrace=False)


def test_every_fault_has_its_row() -> None:
    assert {*KINDS, *CAN_KINDS, *CAMERA_KINDS} <= set(ROWS)
