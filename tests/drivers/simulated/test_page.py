"""The page on simulated devices says what the code does."""

import re

from drivers.simulated.bench_in_memory import SimulatedBench
from drivers.simulated.camera_faults import KINDS as CAMERA_KINDS
from drivers.simulated.effects import EFFECTS
from drivers.simulated.faults import CAN_KINDS, KINDS, load_faults
from drivers.simulated.truth import load_truth
from tests.paths import ROOT

PAGE = (ROOT / "docs/simulated-devices.md").read_text(encoding="utf-8")


def test_the_example_file_is_a_truth_and_faults() -> None:
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    assert set(load_truth(text).effects) == {"accelerometer.quadratic", "placement.dwell"}
    assert [fault.kind for fault in load_faults(text)] == ["lost"]
    SimulatedBench(load_truth(text), 1)


def test_every_effect_and_fault_has_its_row() -> None:
    rows = {row.split("`")[1]: row for row in PAGE.splitlines() if row.startswith("| `")}
    for effect in EFFECTS.values():
        assert effect.unit in rows[effect.name], effect.name
        assert effect.equation.replace("|", "&#124;") in rows[effect.name], effect.name
    assert {*KINDS, *CAN_KINDS, *CAMERA_KINDS} <= set(rows)
