"""A fault of the simulated autopilot never ends it, whatever its size."""

import pytest

from drivers.simulated.autopilot import Autopilot
from drivers.simulated.autopilot_truth import AutopilotTruth
from drivers.simulated.timed_faults import TimedFault
from drivers.simulated.truth import Truth

SYSTEM = 5  # of a frame's bytes


@pytest.mark.parametrize(("size", "system"), [(9.0, 9), (0.0, 77), (3600.0, 3600 % 256), (256.0, 77)])
def test_another_system_is_a_byte_of_the_line(size: float, system: int) -> None:
    faults = [TimedFault("wrong_system", 0.0, 5.0, size)]
    sent = Autopilot(Truth.example(3), AutopilotTruth(default_hz=2.0), faults).due(2.0)
    assert sent[SYSTEM] == system
