"""The page on simulated devices says what the code does."""

import re
import tomllib

from drivers.simulated.bench_in_memory import SimulatedBench
from drivers.simulated.faults import faults_from
from drivers.simulated.truth import load_truth
from tests.paths import ROOT

PAGE = (ROOT / "docs/how-to/simulated-devices.md").read_text(encoding="utf-8")


def test_the_example_file_is_a_truth_and_faults() -> None:
    (text,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    assert set(load_truth(text).effects) == {"accelerometer.quadratic", "placement.dwell"}
    assert [fault.kind for fault in faults_from(tomllib.loads(text)["fault"])] == ["lost"]
    SimulatedBench(load_truth(text), 1)
